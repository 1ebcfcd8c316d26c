"""Which of two fits is preferred, and how clearly. Truth: the criteria of numbers written by hand."""

import math

import pytest

from estimates import record
from mechid.analysis.preference import ComparisonOutcome
from mechid.errors import UsageError


@pytest.mark.parametrize(
    ("rms_b", "held_out_b", "outcome", "preferred"),
    [
        (0.0021, 0.0022, ComparisonOutcome.AGREED, "A"),
        (0.0021, 0.0018, ComparisonOutcome.DISPUTED, "A"),
        (0.0021, 0.002, ComparisonOutcome.UNDECIDED_BY_PREDICTION, "A"),
        (0.0019, 0.0018, ComparisonOutcome.AGREED, "B"),
        (0.002, 0.002, ComparisonOutcome.OPEN, None),  # one parameter less: AIC and BIC for B, AIC by 2 - 0.1
        (0.002 * math.exp(3.0 / 1e4), 0.002, ComparisonOutcome.CRITERIA_DISAGREE, None),
    ],
)
def test_the_verdict(pair, rms_b, held_out_b, outcome, preferred):
    """The last: ln L is 3 lower and k one less, so AIC is 6 - 2 higher, BIC 9.2 - 6 lower."""
    slightly = math.exp(0.05 / 1e4)  # keeps the equal ones off a gap of just 2
    a = {"x": record(0.002), "v": record(0.002, use="validate")}
    b = {"x": record(rms_b * slightly), "v": record(held_out_b, use="validate")}
    found = pair(a, b).preference
    assert found.outcome is outcome
    assert found.preferred == preferred


def test_a_record_that_the_fits_left_out_is_none_held_out(pair):
    """It contradicts the others: to predict it well is no merit, nor do fits that differ in it compare."""
    left = record(0.3, use="validate") | {"taken": {"use": "validate"}}
    found = pair({"x": record(0.002), "v": left}, {"x": record(0.003), "v": left})
    assert found.preference.outcome is ComparisonOutcome.UNTESTED
    assert found.records[1].use == "left out"
    assert [line for line in found.preference.grounds if line.startswith("left out, v: ")]
    with pytest.raises(UsageError, match='B left it out, because it contradicts the others; give it use = "validate"'):
        pair({"x": record(0.002), "v": record(0.003)}, {"x": record(0.003), "v": left})


def test_without_held_out_records_the_prediction_is_untested(pair):
    assert pair({"x": record(0.002)}, {"x": record(0.003)}).preference.outcome is ComparisonOutcome.UNTESTED


def test_a_fit_that_did_not_succeed_is_no_rival(pair):
    found = pair({"x": record(0.002)}, {"x": record(0.001, used=150)}, outcomes=("converged", "horizon"))
    assert found.preference.outcome is ComparisonOutcome.ONLY_ONE
    assert found.preference.preferred == "A"
    assert any("150 of 10000" in line for line in found.cautions)


def test_a_record_that_cannot_be_simulated_is_no_rival(pair):
    found = pair({"x": record(0.002)}, {"x": record(None)})
    assert found.preference.preferred == "A"
    assert math.isinf(found.scores[1].aic_effective)
    assert "B: a record it was estimated from cannot be simulated" in found.preference.grounds[-1]


def test_none_is_preferred_where_none_succeeded(pair):
    found = pair({"x": record(None)}, {"x": record(0.1)}, outcomes=("converged", "failed"))
    assert (found.preference.outcome, found.preference.preferred) == (ComparisonOutcome.NONE, None)


def test_how_clearly_is_said_in_words(pair):
    grounds = pair({"x": record(0.002)}, {"x": record(0.003)}).preference.grounds
    assert grounds[0].startswith("A decisively before B (AIC +8107")  # 1e4 ln 2.25 - 2
