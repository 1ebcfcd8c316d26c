"""Forcing and linear model together on a base that moves, against both simulated at once."""

import numpy as np
import pytest

from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.steady_state import enough_substeps, steady_state
from mechid.command import Command, RateProfile
from mechid.exports.linear.linearisation import HeldMechanism
from mechid.exports.linear.state_space import Uncertain
from mechid.plant.flight import to_flight, with_base
from mechid.plant.layout import Base, Flying
from mechid.plant.small_signal import small_signal
from paper import mechanism

OMEGA, DAMPING, INERTIA = 2.0 * np.pi * 30.0, 0.02, 1.0
"""A base of 1 kg m2 on a spring at 30 Hz: a line changes by some per cent."""
FULL = Command(stepping="full", microsteps=1, rate=RateProfile.constant(46.0), start_angle_deg=45.0)
MICRO = Command(stepping="micro", microsteps=16, rate=RateProfile.constant(40.0))


@pytest.mark.slow
@pytest.mark.parametrize(("command", "rate", "within"), [(FULL, 46.0, 0.02), (MICRO, 40.0, 0.005)])
def test_lines_and_the_response_to_the_base_add_up(command, rate, within):
    """Truth: the mechanism on its structure in one simulation; the lines of a held base alone are further off."""
    held = to_flight(mechanism(housing=None))
    moved = with_base(held, Flying(base=Base.ON_MODES, modes=1), [(OMEGA, DAMPING, 1.0 / np.sqrt(INERTIA))])
    mode = OperatingMode(name="m", command=command, rates=np.array([rate]))
    alone, joined = (steady_state(m, mode, rate, (), enough_substeps(m, mode)) for m in (held, moved))
    empty = Uncertain((), (), np.zeros(0), np.zeros((0, 0)))
    free = HeldMechanism(small_signal(held), command, empty).models(0, 0)["free"]
    s = 2j * np.pi * rate
    base = s**2 / INERTIA / (s**2 + 2.0 * DAMPING * OMEGA * s + OMEGA**2)
    response = free.response([rate])[
        0, free.outputs.names.index("torque"), free.inputs.names.index("base_acceleration")
    ]
    line, truth = (x.lines[np.argmin(np.abs(x.step_orders - 1.0))] for x in (alone, joined))
    added = line / (1.0 - response * base)
    assert abs(added - truth) < within * abs(truth)
    assert abs(line - truth) > 1.5 * within * abs(truth)
