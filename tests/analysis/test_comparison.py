"""Truth: the definitions of AIC and BIC on numbers written by hand, and SciPy's Gaussian likelihood."""

import math

import numpy as np
import pytest
from scipy.stats import norm

import mechid
from estimates import free, known, record, write
from mechid.analysis.preference import ComparisonOutcome
from mechid.errors import InputFileError, UsageError

BOTH = {"gear.stiffness": free(913.0, 0.5), "gear.damping": free(0.39, 0.001)}
ONE = {"gear.stiffness": free(914.0, 0.4), "gear.damping": known(0.48)}


@pytest.fixture
def pair(tmp_path):
    """Return a function that writes and compares two fits, A with two free parameters, B with one."""

    def make(a, b, *, parameters=(BOTH, ONE), outcomes=("converged", "converged")):
        folders = [
            write(tmp_path / name, records, own, outcome)
            for name, records, own, outcome in zip("AB", (a, b), parameters, outcomes, strict=True)
        ]
        return mechid.compare(*folders)

    return make


def test_the_criteria_by_hand(pair):
    """k: two or one free, and of each of two records an offset, a drift and a noise level."""
    a = {"x": record(0.002), "y": record(0.003, samples=5000)}
    b = {"x": record(0.0021), "y": record(0.003, samples=5000)}
    for score, rms, k in zip(pair(a, b).scores, (0.002, 0.0021), (8, 7), strict=True):
        deviance = 1e4 * (math.log(2 * math.pi * rms**2) + 1) + 5e3 * (math.log(2 * math.pi * 9e-6) + 1)
        assert score.counted == k
        assert score.deviance == pytest.approx(deviance, rel=1e-12)
        assert score.aic == score.aic_effective == pytest.approx(deviance + 2 * k, rel=1e-12)
        assert score.bic == score.bic_effective == pytest.approx(deviance + k * math.log(15_000), rel=1e-12)


def test_the_likelihood_is_scipys(pair):
    """Truth: the sum of scipy.stats.norm.logpdf of the residual at its own RMS."""
    r = np.random.default_rng(1).normal(0.0, 0.002, 1000)
    rms = float(np.sqrt(np.mean(r**2)))
    found = pair({"x": record(rms, samples=1000)}, {"x": record(rms, samples=1000)}).scores[0]
    assert found.deviance == pytest.approx(-2.0 * float(np.sum(norm.logpdf(r, scale=rms))), rel=1e-12)


def test_coloured_residuals_count_by_the_effective_samples_of_the_smallest(pair):
    """10 000 samples worth 500 in the better fit, 50 in the worse: 500 ln(s_B^2/s_A^2) between them."""
    found = pair({"x": record(0.002, effective=500.0)}, {"x": record(0.0021, effective=50.0)})
    a, b = found.scores
    assert a.effective_samples == b.effective_samples == 500.0
    gap = 500.0 * math.log(0.0021**2 / 0.002**2) - 2.0
    assert b.aic_effective - a.aic_effective == pytest.approx(gap)
    assert any("coloured: 10000 samples are worth 500" in line for line in found.cautions)


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


@pytest.mark.parametrize(
    ("own", "command", "words"),
    [
        ({"gear.damping": known(0.48), "gear.stiffness": free(914.0, 0.4)}, {}, "are nested: A has 1 free parameter"),
        ({"gear.damping": known(0.48), "load.inertia": free(0.01, 0.1)}, {}, "are not nested"),
        (BOTH | {"gear.damping": known(0.48) | {"status": "at_bound"}}, {}, "have the same free parameters"),
        (BOTH, {"waveform": "square"}, "are not nested"),
        (BOTH, {}, "have the same free parameters"),
    ],
)
def test_whether_one_contains_the_other_is_said(pair, own, command, words):
    found = pair({"x": record(0.002)}, {"x": record(0.003, **command)}, parameters=(BOTH, own))
    assert any(words in line for line in found.preference.grounds)


def test_parameters_stand_side_by_side_in_sigmas(pair):
    """(914 - 913) / 0.5, the larger error; 179 to -179 deg is 2 deg, over 0.5; a known value off by 0.09 / 0.001."""
    own = (
        BOTH | {"phase": free(179.0, 0.5, "deg"), "poles": known(100.0), "only_a": free(1.0, 0.1)},
        ONE | {"phase": free(-179.0, 0.4, "deg"), "poles": known(100.0)},
    )
    rows = {p.name: p for p in pair({"x": record(0.002)}, {"x": record(0.002)}, parameters=own).parameters}
    assert set(rows) == {"gear.stiffness", "gear.damping", "phase", "only_a"}
    differences = {name: row.differences_sigmas for name, row in rows.items()}
    assert differences["gear.stiffness"] == (None, pytest.approx(2.0))
    assert differences["gear.damping"] == (None, pytest.approx(90.0))
    assert differences["phase"] == (None, pytest.approx(4.0))
    assert rows["only_a"].values[1] is None
    assert differences["only_a"] == (None, None)


def test_a_detent_is_known_by_its_period_wherever_it_stands(pair):
    """The harmonic of 3.6 deg is the second of A and the only one of B, which is A without the first."""
    table = {"period_deg": known(3.6, "deg"), "amplitude": free(0.02, 1e-3, "N m")}
    other = {"period_deg": known(1.8, "deg"), "amplitude": free(0.005, 1e-3, "N m")}
    two = {f"stepper.detent.{i}.{key}": p for i, d in enumerate((other, table)) for key, p in d.items()}
    one = {f"stepper.detent.0.{key}": p for key, p in table.items()}
    found = pair({"x": record(0.002)}, {"x": record(0.003)}, parameters=(BOTH | two, BOTH | one))
    rows = {p.name: p.differences_sigmas for p in found.parameters}
    assert rows["stepper.detent.3.6deg.amplitude"] == (None, 0.0)
    assert rows["stepper.detent.1.8deg.amplitude"] == (None, None)
    assert any("are nested: A has 1 free parameter more" in line for line in found.preference.grounds)


@pytest.mark.parametrize(
    ("b", "message"),
    [
        ({"y": record(0.002)}, r'B: no record "x", which A has; compare fits of the same records'),
        ({"x": record(0.002, digest="cd" * 32)}, r'B: record "x": other samples \(sha256 cdcdcdcd, abababab in A\)'),
        ({"x": record(0.002, use="validate")}, r'B: record "x": use = "validate", "estimate" in A'),
    ],
)
def test_other_records_are_refused(pair, b, message):
    with pytest.raises(UsageError, match=message):
        pair({"x": record(0.002)}, b)


def test_one_fit_or_one_twice_is_refused(tmp_path):
    folder = write(tmp_path / "A", {"x": record(0.002)}, BOTH)
    with pytest.raises(UsageError, match="give two or more"):
        mechid.compare(folder)
    with pytest.raises(UsageError, match="given twice"):
        mechid.compare(folder, folder / "estimate.json")


def test_a_fit_without_validation_is_refused(tmp_path):
    entry = record(0.002)
    del entry["validation"]
    folders = [write(tmp_path / name, {"x": r}, BOTH) for name, r in (("A", record(0.002)), ("B", entry))]
    with pytest.raises(InputFileError, match=r"estimate\.json: no 'validation'.*identify anew"):
        mechid.compare(*folders)


def test_folders_of_one_name_are_told_apart_by_their_parents(tmp_path):
    folders = [write(tmp_path / name / "fit", {"x": record(0.002)}, BOTH) for name in ("rigid", "housing")]
    assert [h.name for h in mechid.compare(*folders).hypotheses] == ["rigid/fit", "housing/fit"]


def test_three_are_ranked(tmp_path):
    folders = [write(tmp_path / n, {"x": record(rms)}, BOTH) for n, rms in (("A", 0.003), ("B", 0.002), ("C", 0.004))]
    found = mechid.compare(*folders)
    assert found.preference.preferred == "B"
    assert [line.split()[3] for line in found.preference.grounds[:2]] == ["A", "C"]
