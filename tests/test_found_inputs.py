"""Inputs that once were findings of `make fuzz`. Truth: what was written beside them, or one of mechid's own errors."""

import shutil
from pathlib import Path

import pytest
from fuzz.kinds import KINDS
from fuzz.trial import ACCEPTED, FINDING, read_again, tried

FOUND = sorted((Path(__file__).parents[1] / "fuzz" / "found").iterdir())
BY_NAME = {kind.name: kind for kind in KINDS}


@pytest.mark.parametrize("case", FOUND, ids=lambda case: case.name)
def test_what_was_found_is_read_or_refused(case, tmp_path):
    shutil.copytree(case, tmp_path, dirs_exist_ok=True)
    outcome = read_again(BY_NAME[case.name.rpartition("-")[0]], tmp_path)
    assert outcome.what != FINDING, outcome.words


@pytest.mark.parametrize("name", [name for name in BY_NAME if name != "command"])
def test_a_builder_writes_files_that_mechid_accepts(name, tmp_path):
    """Truth: some of the first inputs of a kind are whole, and none is a finding."""
    outcomes = []
    for number in range(60):
        folder = tmp_path / str(number)
        folder.mkdir()
        outcomes.append(tried(BY_NAME[name], number, folder))
        assert outcomes[-1].what != FINDING, outcomes[-1].words
        if outcomes[-1].what == ACCEPTED:
            return
    pytest.fail(f"none is accepted: {outcomes[:3]}")
