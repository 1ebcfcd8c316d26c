"""What several tests of designs begin with: a small design, its folder and its numbers."""

import json

import pytest

from mechid.campaign.bench import write_bench
from small_design import design


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """Return the folder of a small design: one record planned, three rates to choose from; not to be changed."""
    bench = tmp_path_factory.mktemp("bench")
    write_bench(bench, seed=3, sweep_s=1.0)
    return design(bench, tmp_path_factory)[0]


@pytest.fixture(scope="session")
def data(folder):
    """Return the numbers of that design; not to be changed."""
    return json.loads((folder / "design.json").read_text(encoding="utf-8"))
