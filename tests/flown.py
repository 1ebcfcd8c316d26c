"""Mechanisms of every block of the library as they fly, beside the same on the bench as `simulate` runs it."""

from dataclasses import dataclass

import numpy as np

from layouts import LAYOUTS, SINGLE_STEPPER, changed, mechanism_of, paper_table
from mechid.budget.operating_mode import OperatingMode
from mechid.budget.steady_state import SteadyState, enough_substeps, steady_state
from mechid.command import Command, RateProfile
from mechid.plant.flight import in_flight
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run

RATE_HZ, SECONDS = 200_000.0, 10.0
FULL = Command(stepping="full", microsteps=1, rate=RateProfile.constant(46.0), start_angle_deg=45.0)
MICRO = Command(stepping="micro", microsteps=16, rate=RateProfile.constant(40.0))
COMMANDS = {"full": (FULL, 46.0), "micro": (MICRO, 40.0)}
RIGID = {"housing": None}
CASES = {
    "paper": RIGID,
    **{name: {**changes, **RIGID} for name, changes in LAYOUTS.items() if name not in ("test stand", "three switches")},
    "detent of 7.2 deg": {**RIGID, "stepper": {"detent": [
        {"period_deg": 7.2, "amplitude": 0.004, "phase_deg": 10.0}, {"period_deg": 1.8, "amplitude": 0.0231}]}},
    "kinematic error of the input turn": {
        **RIGID, "gear": {"kinematic_error": [{"order": 1, "amplitude": 1e-4, "phase_deg": 20.0}]}},
    "strong output friction": {**RIGID, "output_friction": {"coulomb": 0.3}},
    "stepper alone": None,
}  # fmt: skip
"""Changes to the paper's file; None is the stepper of its own file, without a gear."""


def mechanism(name: str):
    """Return a mechanism of the table on the bench."""
    if CASES[name] is None:
        return mechanism_of({"assembly": "current_driven_stepper", **SINGLE_STEPPER})
    return mechanism_of(changed(paper_table(), CASES[name]))


@dataclass(frozen=True)
class Compared:
    """What the budget's torque and a long simulation say.

    `off` is the relative difference of the lines above the floor, `lines` the number of all, `rms_off` the relative
    difference of the RMS.
    """

    state: SteadyState
    off: np.ndarray
    lines: int
    rms: float
    rms_off: float

    @property
    def steps(self) -> int:
        return self.state.steps

    @property
    def periods(self) -> int:
        return self.state.periods


def simulated(bench, command, seconds=SECONDS, rate_hz=RATE_HZ):
    """Return the bench's torque from rest, (N,) N m, at a rate of samples that is whole in a period of the steps."""
    base = TimeBase(rate_hz, round(seconds * rate_hz) + 1)
    return simulate_run(Simulator(bench.plant, command, base).run(bench.kernel_values())).torque


def flown(name: str, stepping: str) -> SteadyState:
    """Return the budget's steady state."""
    command, rate = COMMANDS[stepping]
    flying = in_flight(mechanism(name))
    mode = OperatingMode(name="m", command=command, rates=np.array([rate]), highest_hz=800.0, settle_s=1.0)
    return steady_state(flying, mode, rate, (), enough_substeps(flying, mode))


def compared(name: str, stepping: str) -> Compared:
    """Return how the budget's torque compares with the simulated one."""
    command, rate = COMMANDS[stepping]
    state = flown(name, stepping)
    period_s = state.steps * max(state.periods, 1) / rate
    samples = round(period_s * RATE_HZ)
    rate_hz = samples / period_s
    times = max(1, int(0.3 * SECONDS / period_s))
    torque = simulated(mechanism(name), command, max(SECONDS, 3.0 * period_s), rate_hz)[:-1]
    last = torque[len(torque) - times * samples :]
    lines = 2.0 / last.size * np.fft.rfft(last)[state.orders * times]
    above = np.abs(state.lines) > state.floor
    off = np.abs(np.abs(state.lines[above]) / np.abs(lines[above]) - 1.0)
    return Compared(state, off, state.lines.size, state.rms, abs(state.rms / np.std(last) - 1.0))
