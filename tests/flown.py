"""Mechanisms of every block of the library as they fly, beside the same on the bench as `simulate` runs it."""

import math
from dataclasses import dataclass

import numpy as np

from layouts import LAYOUTS, SINGLE_STEPPER, changed, mechanism_of, paper_table
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.steady_state import SteadyState, enough_substeps, steady_state
from mechid.command import Command, RateProfile
from mechid.plant.flight import to_flight
from mechid.signal.power import periodic_power
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run

RATES_HZ = (800_000.0, 1_600_000.0)
"""A sample holds the mean over its interval where the torque jumps, so that lines are off by the first power of it: two
rates tell what is left without."""
SETTLE_S, LAST_S = 12.0, 0.5
FULL = Command(stepping="full", microsteps=1, rate=RateProfile.constant(46.0), start_angle_deg=45.0)
MICRO = Command(stepping="micro", microsteps=16, rate=RateProfile.constant(40.0))
COMMANDS = {"full": (FULL, 46.0), "micro": (MICRO, 40.0)}
RIGID = {"housing": None}
BENCH_ONLY = ("test stand", "unbalance", "three switches")
"""Layouts of which something stays on the bench, or that the others hold already."""
CASES = {
    "paper": RIGID,
    **{name: {**changes, **RIGID} for name, changes in LAYOUTS.items() if name not in BENCH_ONLY},
    "detent of 7.2 deg": {
        **RIGID,
        "stepper": {
            "detent": [
                {"period_deg": 7.2, "amplitude": 0.004, "phase_deg": 10.0},
                {"period_deg": 1.8, "amplitude": 0.0231},
            ]
        },
    },
    "kinematic error of the input turn": {
        **RIGID,
        "gear": {"kinematic_error": [{"order": 1, "amplitude": 1e-4, "phase_deg": 20.0}]},
    },
    "strong output friction": {**RIGID, "output_friction": {"coulomb": 0.3}},
    "stepper alone": None,
}
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


def simulated(bench, command, seconds, rate_hz, start_s=0.0):
    """Return the bench's torque from rest, (N,) N m, at a rate of samples that is whole in a period of the steps."""
    base = TimeBase(rate_hz, round(seconds * rate_hz) + 1, start_s)
    return simulate_run(Simulator(bench.plant, command, base).run(bench.kernel_values())).torque


def flown(name: str, stepping: str) -> SteadyState:
    """Return the budget's steady state."""
    command, rate = COMMANDS[stepping]
    flying = to_flight(mechanism(name))
    mode = OperatingMode(name="m", command=command, rates=np.array([rate]), highest_hz=800.0, settle_s=1.0)
    return steady_state(flying, mode, rate, (), enough_substeps(flying, mode))


def compared(name: str, stepping: str) -> Compared:
    """Return how the budget's torque compares with the simulated one."""
    command, rate = COMMANDS[stepping]
    state = flown(name, stepping)
    period_s = state.steps * max(state.periods, 1) / rate
    times = max(1, int(LAST_S / period_s))
    skipped = math.ceil(SETTLE_S / period_s)
    ways = [_lines(mechanism(name), command, state, period_s, skipped, times, rate_hz) for rate_hz in RATES_HZ]
    lines, power = (2.0 * fine - coarse for coarse, fine in zip(*ways, strict=True))
    above = np.abs(state.lines) > state.floor
    off = np.abs(np.abs(state.lines[above]) / np.abs(lines[above]) - 1.0)  # a sub-harmonic may begin in any period
    return Compared(state, off, state.lines.size, state.rms, abs(state.rms / np.sqrt(power) - 1.0))


def _lines(bench, command, state, period_s, skipped, times, rate_hz):
    """Return the complex lines of the last whole periods, and their mean square about the mean.

    The first sample lies half an interval behind the first step, so that no step falls on a sample, where rounding
    would say to which side it belongs.
    """
    samples = round(period_s * rate_hz)
    late_s = 0.5 * period_s / samples
    torque = simulated(bench, command, (skipped + times) * period_s, samples / period_s, late_s)
    last = torque[skipped * samples : (skipped + times) * samples]
    turned = np.exp(-2j * np.pi * state.frequency_hz * late_s)
    bins = np.rint(state.orders * times).astype(int)  # orders of meshes need not be whole
    return 2.0 / last.size * np.fft.rfft(last)[bins] * turned, periodic_power(last)
