"""Every number of a design. Truth: laws between them, and what no motor of this kind can do."""

import numpy as np
import pytest


def test_what_loses_steps_is_not_chosen(data):
    """Truth: no motor of this kind starts at 600 steps/s; every record takes a second, and one between two."""
    objections = {c["name"]: c["objection"] for c in data["candidates"]}
    assert objections["full_600"] == "loses steps at the values believed"
    assert not objections["full_46"]
    chosen = data["chosen"]
    assert {r["name"] for r in chosen["records"]} == {name for name, why in objections.items() if not why}
    assert chosen["seconds"] == pytest.approx(2.0 * len(chosen["records"]))


def test_more_records_tell_more(data):
    """Truth: the criterion falls with each record; the gain is that of the last over the planned."""
    chosen = data["chosen"]
    assert np.all(np.diff(data["trail"]) < 0.0)
    assert data["gain_factor"] == pytest.approx(np.exp(data["planned"]["criterion"] - chosen["criterion"]))
    assert data["gain_factor"] > 1.0
    for p in data["parameters"]:
        assert p["chosen"] is None or p["chosen"] < p["planned"], p["name"]


def test_each_record_tells_more_of_every_parameter(data):
    """Truth: information adds up, so that no error rises; after the last record it is that of all chosen."""
    for p in data["parameters"]:
        known = [sigma for sigma in p["by_record"] if sigma is not None]
        assert len(p["by_record"]) == 1 + len(data["chosen"]["records"])
        assert np.all(np.diff(known) <= 1e-9 * np.array(known[:-1])), p["name"]
        assert p["by_record"][-1] == (p["chosen_spread"][0] and pytest.approx(p["chosen_spread"][0]))


def test_ranges_of_rates_have_ends_and_holes(data):
    """Truth: a rotor that starts at a rate at once also follows to it slowly; between two ranges is a hole."""
    assert {row["stepping"] for row in data["step_loss"]} == {"full"}
    for row in data["step_loss"]:
        start, slow = row["pull_in"], row["pull_out"]
        assert start["limit"] == start["ranges"][-1][1]
        assert start["rate"] == start["ranges"][0][1]
        assert start["holds_again"] == bool(start["holes"]) == (len(start["ranges"]) > 1)
        assert slow["limit"] is None or slow["limit"] >= start["limit"]


def test_the_torque_believed_lies_among_those_that_may_be_true(data):
    for m in data["torque_over_rate"]:
        low, amplitude, high = (np.array(m[key]) for key in ("low_Nm", "amplitude_Nm", "high_Nm"))
        assert np.all((low <= amplitude) & (amplitude <= high))
