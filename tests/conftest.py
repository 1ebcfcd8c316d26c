"""Fixtures that several layers' tests share."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def campaign_folder():
    """Return the folder of campaigns made by the independent simulator, outside the repository."""
    beside = Path(__file__).resolve().parents[2] / "shared" / "campaign"
    folder = Path(os.environ.get("MECHID_CAMPAIGN", beside))
    if not (folder / "exact").is_dir():
        pytest.skip("no independent campaigns here; set MECHID_CAMPAIGN to the folder with exact/ and noisy/")
    return folder


@pytest.fixture(scope="session")
def data_folder():
    """Return the folder of measured data by others, outside the repository."""
    named = os.environ.get("MECHID_DATA")
    folder = Path(named or Path(__file__).resolve().parents[2] / "shared" / "data")
    if not (folder / "formats").is_dir():
        assert not named, f"MECHID_DATA names {named}, which holds no measured data"
        pytest.skip("no measured data here; set MECHID_DATA to their folder")
    return folder
