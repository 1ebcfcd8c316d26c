"""Dependent parameters: held with words, the shift told, the others' errors widened by what is held."""

import importlib
import math
from dataclasses import replace

import numpy as np
import pytest

from mechid.campaign.identify_options import IdentifyOptions
from mechid.identification.identify import identify
from mechid.identification.uncertainty.dependence import describe_direction
from mechid.parameter import Status
from synthetic import NOISE_NM, bench, displaced, truth

STIFFNESS, DAMPING = "gear.stiffness", "gear.damping"
SHORT_S = 0.12
identification = importlib.import_module("mechid.identification.identify")


def with_options(made, **options):
    return replace(made, options=IdentifyOptions(**options))


@pytest.mark.parametrize(
    ("names", "moved", "words"),
    [
        (["R", "L"], [1.0, 1.05], "R and L rise together: only their ratio is seen"),
        (["R", "L"], [-1.0, -1.0], "R and L rise together: only their ratio is seen"),
        (["K", "J"], [1.0, -0.9], "K rises as J falls: only their product is seen"),
        (["K", "J"], [-1.0, 0.9], "K rises as J falls: only their product is seen"),
        (["K", "J"], [1.0, 0.3], "K and J rise together: only a combination of them is seen"),
        (["a", "b", "c"], [1.0, 0.5, -0.8], "a and b rise together as c fall: only combinations of them are seen"),
        (["a"], [1.0], "a alone moves"),
    ],
)
def test_a_direction_in_words(names, moved, words):
    """Truth: x/y stays along (1, 1), x y along (1, -1), whichever way the direction points."""
    assert describe_direction(names, np.array(moved)) == words


@pytest.fixture(scope="module")
def gear():
    """Return a campaign of the gear alone, well known."""
    return bench(displaced(truth(), {STIFFNESS: 1.1, DAMPING: 0.8}), truth(), "full_46", seed=51, seconds=SHORT_S)


def test_what_is_well_known_is_left_alone(gear):
    """Truth: nothing is dependent, by the rules without limits of the user's."""
    fit = identify(gear, workers=1)
    assert {fit.parameters[n].status for n in (STIFFNESS, DAMPING)} == {"free"}


def test_the_relative_error_asked_for_freezes_what_misses_it(gear):
    """Truth: the file's value for what is held; its shift of the other is the difference of the two fits."""
    free = identify(gear, workers=1)
    limit = 0.5 * free.parameters[DAMPING].std_error / free.parameters[DAMPING].value
    assert free.parameters[STIFFNESS].std_error < limit * free.parameters[STIFFNESS].value
    fit = identify(with_options(gear, max_relative_error=limit), workers=1)
    p = fit.parameters[DAMPING]
    assert (p.status, p.value, p.std_error) == ("frozen", gear.mechanism.value(DAMPING), None)
    assert f"exceeds {limit:g} of its value" in p.reason
    shift = 100.0 * (fit.parameters[STIFFNESS].value / free.parameters[STIFFNESS].value - 1.0)
    assert f"this moved {STIFFNESS} by {shift:+.2g} %" in p.reason
    assert [w for w in fit.warnings if w.startswith(f"{DAMPING}: frozen")]


def test_freezing_can_be_switched_off_and_is_still_told(gear):
    """Truth: the fit without limits, to the bit."""
    free = identify(gear, workers=1)
    fit = identify(with_options(gear, max_relative_error=1e-9, freeze=False), workers=1)
    for name in (STIFFNESS, DAMPING):
        assert fit.parameters[name] == free.parameters[name]
    assert [w for w in fit.warnings if "nothing is frozen" in w]


def test_a_correlation_beyond_the_limit_holds_the_less_influential(gear):
    """Truth: the correlation of the free fit; the stiffness moves this record more than the damping."""
    free = identify(gear, workers=1)
    found = abs(float(free.correlation[0, 1]))
    assert 1e-4 < found < 1.0
    kept = identify(with_options(gear, max_correlation=min(1.5 * found, 0.999)), workers=1)
    held = identify(with_options(gear, max_correlation=0.5 * found), workers=1)
    assert kept.parameters[DAMPING].status == "free"
    assert held.parameters[DAMPING].status == "frozen"
    assert held.parameters[STIFFNESS].status == "free"
    assert f"beyond the limit {0.5 * found:g}" in held.parameters[DAMPING].reason


VOLTAGE = "stepper.peak_voltage"
SCALED = ("stepper.coil_resistance", "stepper.coil_inductance", "stepper.torque_constant", VOLTAGE)
"""U -> c U, k_m -> c k_m, R and L -> c^2 leaves every torque as it is: one parameter too many."""
FACTORS = dict(zip(SCALED, (1.02, 0.97, 1.03, 1.02), strict=True))


def free_voltage(sigma):
    """Return a campaign in which the voltage is free too, with a prior where sigma is a number."""
    q = truth().parameters[VOLTAGE]
    free = replace(q, status=Status.FREE, min=3.0, max=9.0, sigma=sigma)
    start = displaced(truth().with_parameters({VOLTAGE: free}), FACTORS)
    return bench(start, truth(), "full_46", seed=52, seconds=SHORT_S)


@pytest.fixture(scope="module")
def singular():
    """Return the fit of what torque cannot tell apart, past the refusal of such files; the prior is left out."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(identification, "refuse_unidentifiable", lambda _: None)
        made = with_options(free_voltage(0.06), priors="none")
        return made, identify(made, workers=1)


def test_what_is_exactly_dependent_is_held_and_told_in_words(singular):
    """Truth: the equations' exact ambiguity; one of the four is held at the file's value, and the fit is no worse."""
    made, fit = singular
    held = [p for p in (fit.parameters[n] for n in SCALED) if p.status == "frozen"]
    assert len(held) == 1
    assert held[0].value == made.mechanism.value(held[0].name)
    assert "smallest singular value" in held[0].reason
    assert "only combinations of them are seen" in held[0].reason
    assert all(name in held[0].reason for name in SCALED)
    assert "this moved" in held[0].reason
    assert fit.records["full_46"].residual_rms == pytest.approx(NOISE_NM, rel=0.1)


def test_the_rest_is_what_the_ambiguity_makes_of_the_truth(singular):
    """Truth: that which made the record, scaled by the held value's share; the consider covariance left aside."""
    _, fit = singular
    powers = dict(zip(SCALED, (2.0, 2.0, 1.0, 1.0), strict=True))
    held = next(fit.parameters[n] for n in SCALED if fit.parameters[n].status == "frozen")
    scale = (held.value / truth().value(held.name)) ** (1.0 / powers[held.name])
    for name in SCALED:
        p = fit.parameters[name]
        if p is not held:
            assert p.value == pytest.approx(truth().value(name) * scale ** powers[name], rel=2e-2)


def test_a_prior_on_one_of_them_resolves_it(singular, monkeypatch):
    """Truth: nothing but the prior tells of U; the others' errors are those that consider it where U is held."""
    monkeypatch.setattr(identification, "refuse_unidentifiable", lambda _: None)
    fit = identify(free_voltage(0.06), workers=1)
    U = fit.parameters[VOLTAGE]
    assert U.std_error == pytest.approx(0.06, rel=1e-3)
    assert singular[1].parameters[VOLTAGE].status == "frozen"
    for name in SCALED[:-1]:
        considered = singular[1].parameters[name].std_error
        assert fit.parameters[name].std_error == pytest.approx(considered, rel=5e-3)
    assert U.prior.dominates
    assert math.isinf(U.prior.std_error_without)
    assert "mainly its prior's" in U.reason
    assert [w for w in fit.warnings if w.startswith(f"{VOLTAGE}: its standard error is mainly its prior's")]
