"""The verdict on a budget. Truth: the rules, and the dict of its numbers."""

import copy
import re

import pytest

from mechid.budgets.verdict import budget_verdict, unmet


@pytest.mark.parametrize(
    ("margins", "warnings", "tone"),
    [((0.5, 0.4), [], "good"), ((0.5, -0.1), [], "caution"), ((-0.1, -0.2), [], "bad"), ((0.5, 0.4), ["w"], "caution")],
)
def test_the_tone(data, margins, warnings, tone):
    """Truth: the rule. Good where every band is within its limit and nothing is odd, bad where a value is beyond."""
    changed = {**copy.deepcopy(data), "warnings": warnings}
    for row in changed["requirements"]:
        row["decided"] |= {"margin": margins[0], "margin95": [margins[1], 0.9], "met": margins[1] >= 0.0}
    assert budget_verdict(changed).tone == tone


def test_the_verdict_tells_rates_drivers_and_coupling(data):
    """Truth: the dict's own numbers."""
    met, drives, worst, coupling = (answers for _, answers in budget_verdict(data).questions)
    least = min(data["requirements"], key=lambda r: r["decided"]["margin95"][0])
    assert met[0].startswith(f"{least['requirement']}, {least['mode']}")
    assert f"{100.0 * least['decided']['margin']:.1f} % of the limit" in met[0]
    assert next(iter(least["variance_shares"])) in drives[0]
    assert any(re.search(r"avoid 47[.]\d+ to 47[.]\d+ steps/s", line) for line in worst)
    assert "the two-way result decides" in coupling[0]
    scan = data["modes"][0]
    pairs = zip(scan["line_of_sight_rms_two_way_rad"], scan["line_of_sight_rms_rad"], strict=True)
    change = max((joined / held - 1.0 for joined, held in pairs), key=abs)
    assert any(f"scan: joined, the RMS changes by {100.0 * change:+.2g} %" in line for line in coupling)


@pytest.mark.parametrize(
    ("verdict", "tone"), [("pass", "good"), ("not_shown", "caution"), ("not_decidable", "caution"), ("fail", "bad")]
)
def test_requirements_on_the_emission_count(data, verdict, tone):
    """Truth: the rule; the others are met here."""
    text = {"verdict": verdict, "rate": "46", "frequency": "92", "margin": "+1.0"}
    row = {"name": "exported", "direction": "torque", "verdict": verdict, "worst": {}, "text": text}
    changed = {**copy.deepcopy(data), "warnings": [], "emission_requirements": [row | {"worst": {"rate": 46.0}}]}
    for one in changed["requirements"]:
        one["decided"] |= {"margin": 0.5, "margin95": [0.4, 0.9], "met": True}
    found = budget_verdict(changed)
    assert found.tone == tone
    assert f"exported, torque, 46 steps/s, 92 Hz: {verdict}; margin +1.0 dB" in found.questions[0][1]
    assert unmet(changed) == ([] if verdict == "pass" else ["exported"])
