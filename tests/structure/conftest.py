"""The structure of three modes, and the folder of others' models."""

import os
from pathlib import Path

import pytest

from mechid.structure import Modes
from three_modes import DAMPING, FREQUENCY_HZ, INTERFACE, LINE_OF_SIGHT


@pytest.fixture
def modes():
    return Modes(FREQUENCY_HZ, DAMPING, INTERFACE, LINE_OF_SIGHT)


@pytest.fixture(scope="session")
def craig_bampton_folder():
    """Return the folder of published Craig-Bampton models, outside the repository."""
    beside = Path(__file__).resolve().parents[3] / "shared" / "data"
    folder = Path(os.environ.get("MECHID_DATA", beside)) / "craig_bampton" / "cla_test_data_2020"
    if not folder.is_dir():
        pytest.skip("no published Craig-Bampton models here; set MECHID_DATA to the folder with craig_bampton/")
    return folder
