"""A knock on the bench in one record, from the catalogue to the report. Truth: the mechanism, and the knock."""

import json

import pytest

import mechid
from diagnosis_bench import HARMONIC
from diagnosis_bench import made as lacking
from mechid.identification.result.estimate_file import estimate_text
from mechid.identification.result.grade import Cause, FitOutcome, Grade
from mechid.identification.result.record_result import masks_of
from synthetic import NOISE_NM, bench, displaced, truth
from synthetic_knock import SIGMAS, with_knock

FREE = {
    "gear.stiffness": 1.25,
    "gear.damping": 0.6,
    "stepper.torque_constant": 1.1,
    "housing.frequency": 0.95,
}
KNOCKED = "full_46"
AT_S, LASTS_S = 0.25, 0.005


def made():
    return bench(displaced(truth(), FREE), truth(), KNOCKED, "micro_46", seed=31, seconds=0.5)


@pytest.fixture(scope="module")
def fit():
    return mechid.identify(with_knock(made(), AT_S, LASTS_S), workers=1)


@pytest.fixture(scope="module")
def quiet():
    return mechid.identify(made(), workers=1)


def within(fit, sigmas=3.0):
    """Assert that the values lie within some standard errors of what made the records."""
    for name in FREE:
        p = fit.parameters[name]
        assert abs(p.value - truth().value(name)) < sigmas * p.std_error, name


def test_the_record_is_followed_around_the_knock(fit, quiet):
    """Truth: the mechanism; the errors are those of the same records without the knock, a 30th of one left out."""
    within(fit)
    assert fit.outcome is FitOutcome.CONVERGED
    assert fit.path[-1] == "as written, single moments left out"
    assert not fit.missing
    for name in FREE:
        assert fit.parameters[name].std_error == pytest.approx(quiet.parameters[name].std_error, rel=0.2)
    own = fit.records[KNOCKED]
    assert own.residual_over_noise == pytest.approx(1.0, abs=0.1)
    assert own.noise_rests_on == quiet.records[KNOCKED].noise_rests_on


def test_the_moment_is_reported_and_judged_by_what_it_costs(fit):
    """Truth: when the knock was, how large, and the sum of its squares."""
    (moment,) = fit.records[KNOCKED].masked
    assert moment.from_s <= AT_S < AT_S + LASTS_S <= moment.to_s <= AT_S + LASTS_S + 0.01
    assert moment.largest == pytest.approx(SIGMAS * NOISE_NM, rel=0.1)
    assert moment.over_noise == pytest.approx(SIGMAS, rel=0.1)
    squares = 0.5 * SIGMAS**2 * LASTS_S * 1e4
    assert moment.chi_square == pytest.approx(squares, rel=0.1)
    (reason,) = fit.reasons
    assert (fit.grade, reason.cause, reason.record) == (Grade.B, Cause.MASKED, KNOCKED)
    assert reason.instant_s == moment.from_s
    (said,) = (line for line in fit.warnings if "left out" in line)
    assert f"{moment.chi_square:.3g}" in said
    assert fit.records[KNOCKED].rejected == moment.stop - moment.first
    assert fit.records[KNOCKED].followed_percent == pytest.approx(100.0 * (1.0 - 150 / 5001))
    assert fit.records["micro_46"].masked == ()


def test_without_a_knock_nothing_is_left_out(quiet):
    assert (quiet.grade, masks_of(quiet.records)) == (Grade.A, {})
    assert quiet.path == ("as written",)


def test_the_estimate_has_the_moment(fit):
    content = json.loads(estimate_text(fit))
    (moment,) = content["records"][KNOCKED]["masked"]
    assert moment == content["records"][KNOCKED]["channels"]["torque"]["masked"][0]
    assert (moment["first"], moment["stop"]) == masks_of(fit.records)[KNOCKED][0]
    assert content["records"]["micro_46"]["masked"] == []


def test_what_uses_the_fit_leaves_the_moment_out(fit):
    """Truth: the optimum of the search."""
    optimum = fit.optimum_on(1)
    values = optimum.problem.coordinates.values(optimum.q)
    assert values == pytest.approx({name: fit.parameters[name].value for name in FREE}, rel=1e-5)
    masked = {t.name: t.leading.masked.size for t in optimum.problem.targets}
    assert masked == {KNOCKED: 150, "micro_46": 0}


@pytest.mark.slow
def test_what_is_missing_beside_a_knock_is_named():
    """Truth: the harmonic that the mechanism file lacks, and the knock."""
    found = mechid.identify(with_knock(lacking(HARMONIC), 0.2, LASTS_S), workers=1)
    assert [one.name for one in found.missing] == [f"stepper.torque_harmonic:{HARMONIC['order']}"]
    assert masks_of(found.records).keys() == {KNOCKED}
    assert found.records[KNOCKED].residual_over_noise == pytest.approx(1.0, abs=0.1)


@pytest.mark.slow
def test_a_knock_that_lasts_is_not_left_out_silently():
    """Truth: 100 ms of it, which is no single moment."""
    found = mechid.identify(with_knock(made(), AT_S, 0.1), workers=1)
    assert masks_of(found.records) == {}
    assert any("noise level was raised" in line for line in found.warnings)
    within(found)
