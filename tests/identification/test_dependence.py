"""Dependent parameters: held with words, the shift told, the others' errors widened by what is held."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.campaign.identify_options import IdentifyOptions
from mechid.identification.dependence import in_words
from mechid.identification.identify import identify
from synthetic import bench, displaced, truth

SCALED = ("stepper.coil_resistance", "stepper.torque_constant", "stepper.peak_voltage")
STIFFNESS, INERTIA, DAMPING = "gear.stiffness", "load.inertia", "gear.damping"
SHORT_S = 0.12


def with_options(made, **options):
    return replace(made, options=IdentifyOptions(**options))


def with_parameter(made, name, **changes):
    """Return a campaign in which a parameter of the mechanism has other attributes."""
    q = replace(made.mechanism.parameters[name], **changes)
    return replace(made, mechanism=made.mechanism.with_parameters({name: q}))


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
    assert in_words(names, np.array(moved)) == words


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


CURRENT = {"stepper.coil_resistance": 1.0, "stepper.peak_voltage": 1.1}
"""At one step in 20 s the coils are settled and emf is nothing: torque tells of U/R alone, but for the transient."""


def free_voltage(made, *, sigma=None):
    """Return a campaign in which the voltage is free too: with R, L and k_m it is one parameter too many."""
    return with_parameter(made, "stepper.peak_voltage", status="free", min=3.0, max=9.0, sigma=sigma)


SINGULAR_SET = ("stepper.coil_resistance", "stepper.coil_inductance", "stepper.torque_constant")


@pytest.fixture(scope="module")
def singular():
    """Return a campaign with R, L, k_m and U free, which torque cannot tell apart, past the refusal of such files."""
    factors = {**dict.fromkeys(SINGULAR_SET, 1.0), "stepper.peak_voltage": 1.0}
    return bench(displaced(truth(), factors), truth(), "full_46", seed=52, seconds=SHORT_S)
