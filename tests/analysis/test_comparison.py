"""Truth: the definitions of AIC and BIC on numbers written by hand, and SciPy's Gaussian likelihood."""

import math

import numpy as np
import pytest
from scipy.stats import norm

import mechid
from estimates import BOTH, ONE, free, known, record, write
from mechid.errors import UsageError


def test_the_criteria_by_hand(pair):
    """k: two or one free, and of each of two records an offset, a drift and a noise level."""
    a = {"x": record(0.002), "y": record(0.003, samples=5000)}
    b = {"x": record(0.0021), "y": record(0.003, samples=5000)}
    for score, rms, k in zip(pair(a, b).scores, (0.002, 0.0021), (8, 7), strict=True):
        deviance = 1e4 * (math.log(2 * math.pi * rms**2) + 1) + 5e3 * (math.log(2 * math.pi * 9e-6) + 1)
        assert score.fitted_count == k
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


def test_one_fit_or_one_twice_is_refused(tmp_path):
    folder = write(tmp_path / "A", {"x": record(0.002)}, BOTH)
    with pytest.raises(UsageError, match="give two or more"):
        mechid.compare(folder)
    with pytest.raises(UsageError, match="given twice"):
        mechid.compare(folder, folder / "estimate.json")


def test_three_are_ranked(tmp_path):
    folders = [write(tmp_path / n, {"x": record(rms)}, BOTH) for n, rms in (("A", 0.003), ("B", 0.002), ("C", 0.004))]
    found = mechid.compare(*folders)
    assert found.preference.preferred == "B"
    assert [line.split()[3] for line in found.preference.grounds[:2]] == ["A", "C"]
