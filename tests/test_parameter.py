"""Parameters and how they are declared. Truth: by hand, and the angle itself."""

import math

import pytest

from mechid.parameter import Declaration, Parameter, Status

PHASE = Declaration("phase_deg", "phi", "deg", "phase")
FREQUENCY = Declaration("frequency", "w", "rad/s", "frequency", hertz_below=100.0)
DAMPING = Declaration("damping", "zeta", "1", "damping ratio", percent_above=0.5)


def angle(value, **bounds):
    return Parameter(name="stepper.detent.0.phase_deg", value=value, declaration=PHASE, **bounds)


@pytest.mark.parametrize(
    ("bounds", "periodic"),
    [({}, True), ({"min": -180.0, "max": 180.0}, True), ({"min": -90.0, "max": 90.0}, False)],
)
def test_an_angle_that_may_turn_all_round_is_periodic(bounds, periodic):
    assert angle(0.0, **bounds).is_periodic is periodic
    inertia = Declaration("inertia", "J", "kg m2", "inertia")
    assert not Parameter(name="load.inertia", value=1.0, declaration=inertia, **bounds).is_periodic


@pytest.mark.parametrize("value", [-540.5, -180.0, -179.5, 0.0, 179.5, 180.0, 359.0, 720.25])
def test_a_periodic_angle_is_the_same_direction_after_it_was_moved(value):
    """Truth: sine and cosine; it is reported from -180 to below 180 degrees."""
    moved = angle(0.0).at_value(value).value
    assert -180.0 <= moved < 180.0
    for function in (math.sin, math.cos):
        assert function(math.radians(moved)) == pytest.approx(function(math.radians(value)), abs=1e-12)


def test_a_bounded_angle_and_a_free_one_within_its_turn_stay_as_they_are():
    assert angle(0.0, min=0.0, max=200.0).at_value(190.0).value == 190.0
    assert angle(0.0, min=0.0, max=360.0).at_value(90.0).value == 90.0


@pytest.mark.parametrize(
    ("declaration", "value", "asked"),
    [
        (FREQUENCY, 46.0, "in Hz"),
        (FREQUENCY, 100.0, ""),
        (FREQUENCY, 0.0, ""),
        (DAMPING, 2.0, "write 0.02 for 2 %"),
        (DAMPING, 0.5, ""),
        (PHASE, 1e6, ""),
    ],
)
def test_a_value_that_looks_like_another_unit_is_asked_about(declaration, value, asked):
    """Truth: the limits of the declaration, at which a value is still believed."""
    doubt = declaration.doubt(value)
    assert asked in doubt
    assert bool(doubt) == bool(asked)


def test_only_a_free_parameter_may_be_moved_by_the_fit():
    assert [status for status in Status if angle(0.0, status=status).is_free] == [Status.FREE]
