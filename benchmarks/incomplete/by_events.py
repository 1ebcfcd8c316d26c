"""Second simulator of the benches: flux linkages and the gear's twist as states, SciPy's DOP853, located events.

Written from the equations of docs/blocks, not from plant.py, of which only the names of the values are taken: a coding
error in one of both shows as a difference. It has the effects of `hardware.HARDWARE` alone.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numba import njit
from scipy.integrate import DOP853
from scipy.signal import butter

from incomplete.plant import Values

RTOL, ATOL = 1e-7, 1e-10
"""Tolerances of a step, SI units; twist and its rate are states, so that the angle's own size costs no torque."""
LONGEST_S, LOOKS = 4e-4, 5
"""Longest step, and instants within each at which events are looked for: a stick or slip between two is missed."""
HALVINGS = 60
PSI_A, PSI_B, ALPHA, OMEGA, TWIST, TWIST_RATE, Z, Z_RATE, SLOW, FILTER = range(10)
"""States: flux linkages, rotor, twist at the output, housing, charge amplifier's loss; from FILTER on a low-pass."""
ABSENT = (
    "hysteresis_stiffness",
    "saturation",
    "warming",
    "inductance_share",
    "chopper",
    "lag_torque",
    "cross_gain",
)
"""Sizes of effects that this simulator has not."""


@dataclass
class Modes:
    """How rotor and output move (0 at rest, else the direction of sliding) and which flank of the gear touches.

    An output without dry friction always moves; its direction is 1 and costs nothing.
    """

    rotor: int = 0
    output: int = 1
    flank: int = 1

    @property
    def now(self) -> tuple[int, int, int]:
        """Modes as the equations take them."""
        return self.rotor, self.output, self.flank


@njit(cache=True)
def _drive_train(v, x, flank):
    """Return motor torque, gear torque at the output, and the output's angle per angle of the rotor with its slope."""
    electrical = v.half_poles * x[ALPHA]
    current_a, current_b = x[PSI_A] / (v.L * (1.0 + v.r_L)), x[PSI_B] / (v.L * (1.0 - v.r_L))
    torque = v.k_m * (1.0 + v.r_k) * current_a * _flux_slope(v, electrical)
    torque += v.k_m * (1.0 - v.r_k) * current_b * _flux_slope(v, electrical + 0.5 * math.pi)
    for order, amplitude, phase in (
        (v.detent_order_1, v.detent_1, v.detent_phase_1),
        (v.detent_order_2, v.detent_2, v.detent_phase_2),
        (v.detent_order_3, v.detent_3, v.detent_phase_3),
    ):
        torque -= amplitude * math.sin(order * x[ALPHA] + phase)
    argument = v.kinematic_order * x[ALPHA] + v.kinematic_phase
    slope = 1.0 / v.G + v.kinematic_order * v.kinematic * math.cos(argument)
    bend = -(v.kinematic_order**2) * v.kinematic * math.sin(argument)
    gear = 0.0 if flank == 0 else v.K_s * (x[TWIST] - 0.5 * v.backlash * flank) + v.D * x[TWIST_RATE]
    return torque, gear, slope, bend


@njit(cache=True)
def _flux_slope(v, electrical):
    """Return the slope of a phase's magnet flux over its electrical angle, over that of the fundamental."""
    return math.sin(electrical) + v.harmonic * math.sin(v.harmonic_order * electrical + v.harmonic_phase)


@njit(cache=True)
def _unevenness(v, x):
    """Return dry friction over its mean, at the angle of rotor or output."""
    if v.angle_share == 0.0:
        return 1.0
    angle = x[ALPHA]
    if v.angle_of_rotor == 0.0:
        error = v.kinematic * math.sin(v.kinematic_order * x[ALPHA] + v.kinematic_phase)
        angle = x[ALPHA] / v.G + error - x[TWIST]
    return 1.0 + v.angle_share * math.sin(2.0 * math.pi * angle / v.angle_period + v.angle_phase)


@njit(cache=True)
def _accelerations(v, x, modes):
    """Return the accelerations of rotor, output and twist, rad/s2."""
    rotor, output, flank = modes
    torque, gear, slope, bend = _drive_train(v, x, flank)
    of_rotor = 0.0
    if rotor != 0:
        speed = x[OMEGA]
        dry = v.coulomb
        if v.stribeck_rate > 0.0:
            dry += (v.static - v.coulomb) * math.exp(-(speed**2) / v.stribeck_rate**2)
        dry = dry * _unevenness(v, x) + v.load_share * abs(gear * slope)
        of_rotor = (torque - gear * slope - v.viscous * speed - rotor * dry) / v.J_rot
    of_output = 0.0 if output == 0 else (gear - output * v.output_coulomb) / v.J_m
    return of_rotor, of_output, slope * of_rotor + bend * x[OMEGA] ** 2 - of_output


@njit(cache=True)
def _torque(v, x, of_rotor, of_output):
    """Return the torque on the transducer and what the charge amplifier passes of it."""
    torque = -x[Z] - v.J_m * of_output
    return torque, torque - x[SLOW] if v.amplifier_s > 0.0 else torque


@njit(cache=True)
def _rates(v, x, u_a, u_b, modes, low, drive):
    """Return the states' time derivatives, (9 + order of the low-pass,)."""
    out = np.empty(x.size)
    of_rotor, of_output, of_twist = _accelerations(v, x, modes)
    electrical = v.half_poles * x[ALPHA]
    decay_a = v.R * (1.0 + v.r_R) / (v.L * (1.0 + v.r_L))
    decay_b = v.R * (1.0 - v.r_R) / (v.L * (1.0 - v.r_L))
    emf = v.k_m * x[OMEGA]
    out[PSI_A] = u_a - decay_a * x[PSI_A] - emf * (1.0 + v.r_k) * _flux_slope(v, electrical)
    out[PSI_B] = u_b - decay_b * x[PSI_B] - emf * (1.0 - v.r_k) * _flux_slope(v, electrical + 0.5 * math.pi)
    out[ALPHA], out[OMEGA] = x[OMEGA], of_rotor
    out[TWIST], out[TWIST_RATE] = x[TWIST_RATE], of_twist
    out[Z] = x[Z_RATE]
    out[Z_RATE] = v.w_0 * (v.w_0 * (v.K_res * v.J_rot * of_rotor - x[Z]) - 2.0 * v.zeta * x[Z_RATE])
    torque, passed = _torque(v, x, of_rotor, of_output)
    out[SLOW] = (torque - x[SLOW]) / v.amplifier_s if v.amplifier_s > 0.0 else 0.0
    for row in range(drive.size):
        rate = drive[row] * passed
        for column in range(drive.size):
            rate += low[row, column] * x[FILTER + column]
        out[FILTER + row] = rate
    return out


@njit(cache=True)
def _measured(v, states, modes, pick):
    """Return what is recorded at states (n, states): (n,) N m."""
    out = np.empty(len(states))
    for row in range(len(states)):
        x = states[row]
        of_rotor, of_output, _ = _accelerations(v, x, modes)
        out[row] = _torque(v, x, of_rotor, of_output)[1]
        if pick.size:
            out[row] = 0.0
            for column in range(pick.size):
                out[row] += pick[column] * x[FILTER + column]
    return out


@njit(cache=True)
def _holding(v, x, flank):
    """Return by how much the pull at rest exceeds what friction holds, and the pull, at rotor and at output, N m."""
    torque, gear, slope, _ = _drive_train(v, x, flank)
    pull = torque - gear * slope
    hold = v.static * _unevenness(v, x) + v.load_share * abs(gear * slope)
    return abs(pull) - hold, pull, abs(gear) - v.output_coulomb - v.output_stiction, gear


@njit(cache=True)
def _events(v, x, modes):
    """Tell whether the rotor's mode, the output's and the flank's have ended."""
    rotor, output, flank = modes
    held = _holding(v, x, flank)
    ended_rotor = held[0] > 0.0 if rotor == 0 else rotor * x[OMEGA] < 0.0
    ended_output = False
    if v.output_coulomb > 0.0:
        slope = _drive_train(v, x, flank)[2]
        rate = slope * x[OMEGA] - x[TWIST_RATE]
        ended_output = held[2] > 0.0 if output == 0 else output * rate < 0.0
    return ended_rotor, ended_output, _touching(v, x) != flank


@njit(cache=True)
def _first_ended(v, states, modes):
    """Return the first of states (states, n) at which a mode has ended, -1 where none has."""
    for column in range(states.shape[1]):
        ended = _events(v, states[:, column], modes)
        if ended[0] or ended[1] or ended[2]:
            return column
    return -1


@njit(cache=True)
def _touching(v, x):
    """Return which flank of the gear touches, 0 in the gap; without backlash always the one that is there."""
    if v.backlash == 0.0 or x[TWIST] >= 0.5 * v.backlash:
        return 1
    return -1 if x[TWIST] <= -0.5 * v.backlash else 0


@dataclass
class _Simulation:
    """A run under way.

    Attributes
    ----------
    values : record of floats
        As `Values`.
    low, drive, pick : (n, n), (n,), (n,)
        Low-pass of order n: rate of its states from its states, from its input, and its output.
    """

    values: np.void
    low: np.ndarray
    drive: np.ndarray
    pick: np.ndarray
    x: np.ndarray
    modes: Modes = field(default_factory=Modes)
    t: float = 0.0

    def until(self, end: float, voltages: Sequence[float], due: np.ndarray, write: Callable) -> None:
        """Integrate to `end` at constant voltages; `write(times, torque)` gets what is recorded at the times due."""
        v = self.values
        u_a, u_b = v["U"] * voltages[0] + v["offset_A"], v["U"] * voltages[1] + v["offset_B"]
        while self.t < end:
            modes = self.modes.now
            solver = DOP853(
                lambda _, x, now=modes: _rates(self.values, x, u_a, u_b, now, self.low, self.drive),
                self.t,
                self.x,
                end,
                rtol=RTOL,
                atol=ATOL,
                max_step=LONGEST_S,
                first_step=min(LONGEST_S, end - self.t),
            )
            while solver.status == "running":
                message = solver.step()
                if message:
                    raise ArithmeticError(message)
                course = solver.dense_output()
                upto = self._first_event(course, solver.t_old, solver.t, modes)
                last = solver.t if upto is None else upto
                now = due[(due > solver.t_old) & (due <= last)] if due.size else due
                if now.size:
                    write(now, _measured(self.values, course(now).T.copy(), modes, self.pick))
                if upto is not None:
                    self.t, self.x = upto, course(upto)
                    self._switch(*_events(self.values, self.x, modes))
                    break
            else:
                self.t, self.x = end, solver.y

    def _first_event(self, course: Callable, start: float, end: float, modes: tuple[int, int, int]) -> float | None:
        """Return the instant just past the first event within a step, None without one."""
        looks = np.linspace(start, end, LOOKS + 1)
        seen = _first_ended(self.values, course(looks[1:]), modes)
        if seen < 0:
            return None
        low, high = looks[seen], looks[seen + 1]
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            if any(_events(self.values, course(middle), modes)):
                high = middle
            else:
                low = middle
        return float(high)

    def _switch(self, rotor: bool, output: bool, flank: bool) -> None:
        """Put the state on an event, and how what has ended goes on."""
        v, x, m = self.values, self.x, self.modes
        if flank:
            m.flank = _touching(v, x)
        slope = _drive_train(v, x, m.flank)[2]
        if rotor and m.rotor != 0:  # its motion goes out of the twist's rate: the output moves on as it did
            x[TWIST_RATE] -= slope * x[OMEGA]
            x[OMEGA] = 0.0
        if output and m.output != 0:
            x[TWIST_RATE] = slope * x[OMEGA]
        excess, pull, excess_output, pull_output = _holding(v, x, m.flank)
        if rotor:
            m.rotor = 0 if excess <= 0.0 else int(math.copysign(1.0, pull))
        if output:
            m.output = 0 if excess_output <= 0.0 else int(math.copysign(1.0, pull_output))


def run(
    values: Values,
    edges: np.ndarray,
    voltages: np.ndarray,
    start_angle: float,
    interval: float,
    samples: int,
    delay: float = 0.0,
) -> np.ndarray:
    """Return the recorded torque, (samples,) N m, one sample every `interval` s; parameters as of `plant.run`.

    Raises
    ------
    ValueError
        The values have an effect that this simulator has not.
    """
    foreign = [name for name in ABSENT if getattr(values, name)]
    if foreign:
        raise ValueError(f"the second simulator has no {', '.join(foreign)}")
    simulation = _at_rest(values, voltages[0], start_angle)
    times, out = interval * np.arange(samples) - delay, np.empty(samples)
    out[times <= 0.0] = _measured(simulation.values, simulation.x[None, :], simulation.modes.now, simulation.pick)[0]

    def write(at: np.ndarray, torque: np.ndarray) -> None:
        out[np.rint((at + delay) / interval).astype(int)] = torque

    within = edges[edges < times[-1]]
    for start, end, held in zip([0.0, *within], [*within, times[-1]], voltages, strict=False):
        first, last = np.searchsorted(times, [start, end], side="right")
        simulation.until(end, held, times[first:last], write)
    return out


def _at_rest(values: Values, voltages: np.ndarray, start_angle: float) -> _Simulation:
    """Return a run at its beginning: currents settled, the rotor where the coils are told to hold it, no twist."""
    record = np.array([tuple(values)], dtype=[(name, np.float64) for name in Values._fields])[0]
    order = int(values.alias_order)
    low, drive, pick = np.zeros((0, 0)), np.zeros(0), np.zeros(0)
    if order:
        numerator, denominator = butter(order, 1.0, analog=True)  # in units of its corner, so that no power overflows
        low = values.alias_w * np.vstack([np.eye(order, k=1)[:-1], -denominator[:0:-1]])
        drive = values.alias_w * np.eye(order)[-1]
        pick = numerator[-1] * np.eye(order)[0]
    x = np.zeros(FILTER + order)
    x[ALPHA] = start_angle / values.half_poles
    for state, side, u, offset in (
        (PSI_A, 1.0, voltages[0], values.offset_A),
        (PSI_B, -1.0, voltages[1], values.offset_B),
    ):
        current = (values.U * u + offset) / (values.R * (1.0 + side * values.r_R))
        x[state] = values.L * (1.0 + side * values.r_L) * current
    simulation = _Simulation(record, low, drive, pick, x)
    simulation.modes.flank = _touching(record, x)
    simulation._switch(rotor=True, output=values.output_coulomb > 0.0, flank=False)
    return simulation
