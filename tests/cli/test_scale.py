"""mechid at the sizes it is meant for, by `benchmarks/scale.py`; truth: what that made, and the promise of 600 MB."""

import json

import pytest

from scale import UNSEEN_PHASES, in_format, many_parameters, many_records, run

PROMISED = 600e6

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("kind", ["csv", "npy"])
def test_an_hour_is_checked_in_little_memory(tmp_path, kind):
    row = run(in_format(tmp_path, 3600.0, kind), "check")
    assert row["exit"] == 0
    assert row["peak"] < PROMISED


def test_five_hundred_records_are_checked_in_little_memory(tmp_path):
    row = run(many_records(tmp_path, 500), "check")
    assert row["exit"] == 0
    assert row["peak"] < PROMISED


def test_of_sixty_parameters_those_that_no_record_sees_are_named(tmp_path):
    """Truth: 30 are phases of harmonics without amplitude, which change no sample."""
    campaign = many_parameters(tmp_path)
    run(campaign, "identify")
    parameters = json.loads((campaign / "result" / "estimate.json").read_text())["parameters"]
    unseen = {name for name, p in parameters.items() if "no record sees it" in p["reason"]}
    assert len(unseen) == UNSEEN_PHASES
    assert not any(name in p["reason"] for name in unseen for p in parameters.values())
    assert all(parameters[name]["std_error"] is None for name in unseen)
