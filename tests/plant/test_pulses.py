"""Tables of a pulsed drive: what is refused, and what a mechanism then declares and measures. Truth: the messages."""

import pytest

from layouts import paper_with
from mechid.command import Command, RateProfile
from mechid.errors import InputFileError, UsageError
from mechid.plant.superset import words_of

OPEN = {"on_s": 0.01, "clamp_V": 8.0}
IDEAL = dict.fromkeys(("peak_voltage", "coil_resistance", "coil_inductance", "back_emf_constant"))


def pulsed(pulses, **stepper):
    return paper_with({"stepper": {"pulses": pulses, **stepper}})


@pytest.mark.parametrize(
    ("pulses", "stepper", "message"),
    [
        ({**OPEN, "diode_drop_V": -0.1}, {}, "stepper.pulses.diode_drop_V: "),
        ({"between": "held", "on_s": 0.01, "hold": 1.2}, {}, "stepper.pulses.hold: "),
        (
            {"between": "held", "on_s": 0.01, "hold": 0.5, "clamp_V": 8.0},
            {},
            'stepper.pulses.clamp_V: unknown key; it belongs to between = "open"',
        ),
        ({"on_s": 0.01}, {}, "stepper.pulses.clamp_V: missing"),
        ({**OPEN, "between": "shut"}, {}, "stepper.pulses.between: unknown between"),
        (OPEN, {"phases": 3, "phase_shift_deg": None}, "stepper.pulses: open phases are of two or four"),
        (OPEN, {"drive": "current", "peak_current": 0.5, **IDEAL}, 'open phases need drive = "voltage"'),
        (OPEN, {"drive": "measured_voltage", "peak_voltage": None}, "has the pulses in its channels; delete the table"),
        (OPEN, {"imbalance": {"torque_constant": 0.02}}, "stepper.imbalance: does not know of phases that are open"),
        ({**OPEN, "between": "open_both_ways"}, {}, "clamps of a bridge conduct both ways anyway"),
    ],
)
def test_what_cannot_be_is_refused(pulses, stepper, message):
    """Truth: one line with the place, what was found and the remedy."""
    with pytest.raises(InputFileError) as caught:
        pulsed(pulses, **stepper)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_step_shorter_than_a_pulse_is_refused():
    """Truth: the message; 100 steps/s of 10 ms just have room for the pulses."""
    m = pulsed(OPEN)
    command = Command(stepping="full", microsteps=1, rate=RateProfile.constant(100.0))
    assert m.command_for(command).pulse == m.pulse
    faster = Command(stepping="half", microsteps=2, rate=RateProfile.constant(100.0))
    with pytest.raises(UsageError, match=r"rate: a step every 0.005 s is shorter than stepper.pulses.on_s = 0.01 s"):
        m.command_for(faster)


def test_it_measures_every_coil():
    """Truth: two coils of a bipolar motor, four halves of a unipolar one, each with current and voltage."""
    offered = [q for q in pulsed(OPEN).plant.offered if "phase" in q]
    assert sorted(offered) == ["current_phase_a", "current_phase_b", "voltage_phase_a", "voltage_phase_b"]
    halves = [q for q in pulsed(OPEN, phases=4).plant.offered if "phase" in q]
    assert len(halves) == 8


def test_no_term_is_proposed_that_would_be_refused():
    """Truth: tables that do not know of open phases are no candidates."""
    names = words_of(pulsed(OPEN))
    assert not {n for n in names if n.startswith(("stepper.imbalance", "stepper.microstep", "stepper.phase", "supply"))}
