"""The mechanism of a lab bench typed by hand: Runge-Kutta steps split at step edges, stick and slip located.

Nothing of mechid is used here: this is what its results are held against.
"""

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numba import njit

STEP_S = 1.25e-5
"""Longest integration step: a quarter of a radian of the filter."""
DIFFERENCE = 1e-7
"""Of angles by which a torque's slope is told, rad."""
BISECTIONS = 48
"""Halvings of a step about a switch: to a few ulp."""
I_A, I_B, ALPHA, OMEGA, OUT, OUT_RATE, MODE, TABLE = 0, 1, 2, 3, 4, 5, 6, 10
FILTER, STATES = 12, 16
"""Behind the six of the drive: deflections and rates of two modes, the table's, two sections of the filter."""


class Values(NamedTuple):
    """The mechanism's values in SI units, angles in rad; an inertia of 0 leaves a mode away."""

    U: float
    half_poles: float
    J_rot: float
    R: float
    L: float
    k_m: float
    detent_order_1: float
    detent_1: float
    detent_phase_1: float
    detent_order_2: float
    detent_2: float
    detent_phase_2: float
    static: float
    coulomb: float
    viscous: float
    G: float
    K_s: float
    D: float
    error_order: float
    error: float
    error_phase: float
    J_m: float
    w_1: float
    zeta_1: float
    J_1: float
    w_2: float
    zeta_2: float
    J_2: float
    w_t: float
    zeta_t: float
    w_c: float


def values_of(value: Callable[[str], float], modes: int) -> Values:
    """Return the values of a mechanism, given by dotted names in its file's units, with so many modes of the load."""
    named: dict[str, float] = {}
    for k in (0, 1):
        name = f"stepper.detent.{k}"
        named[f"detent_order_{k + 1}"] = 360.0 / value(f"{name}.period_deg")
        named[f"detent_{k + 1}"] = value(f"{name}.amplitude")
        named[f"detent_phase_{k + 1}"] = math.radians(value(f"{name}.phase_deg"))
        mode = f"load.mode.{k}"
        there = k < modes
        named[f"w_{k + 1}"] = value(f"{mode}.frequency") if there else 1.0
        named[f"zeta_{k + 1}"] = value(f"{mode}.damping") if there else 1.0
        named[f"J_{k + 1}"] = value(f"{mode}.inertia") if there else 0.0
    error = "gear.kinematic_error.0"
    return Values(
        U=value("stepper.peak_voltage"),
        half_poles=0.5 * value("stepper.poles"),
        J_rot=value("stepper.rotor_inertia"),
        R=value("stepper.coil_resistance"),
        L=value("stepper.coil_inductance"),
        k_m=value("stepper.torque_constant"),
        static=value("friction.static"),
        coulomb=value("friction.coulomb"),
        viscous=value("friction.viscous"),
        G=value("gear.ratio"),
        K_s=value("gear.stiffness"),
        D=value("gear.damping"),
        error_order=value(f"{error}.order"),
        error=value(f"{error}.amplitude"),
        error_phase=math.radians(value(f"{error}.phase_deg")),
        J_m=value("load.inertia"),
        w_t=value("transducer.frequency"),
        zeta_t=value("transducer.damping"),
        w_c=value("anti_alias.frequency"),
        **named,
    )


def run(
    values: Values, edges: np.ndarray, voltages: np.ndarray, start_angle: float, sample_rate_hz: float, samples: int
) -> Mapping[str, np.ndarray]:
    """Return recorded torque, N m, and rotor rate, rad/s, (samples,) each; at rest in balance until the first edge.

    Parameters
    ----------
    values : Values
    edges, voltages : (E,) s of record time and (E + 1, 2)
        As `incomplete.stepping.edges` returns them.
    start_angle : float
        Electrical angle in rad at which the coils hold the rotor at the start.
    sample_rate_hz : float
    samples : int
    """
    record = np.array([tuple(values)], dtype=[(name, np.float64) for name in Values._fields])[0]
    angle = _balance(record, voltages[0], start_angle / values.half_poles)
    torque, rate = _run(record, edges, voltages, angle, 1.0 / sample_rate_hz, samples)
    return {"torque": torque, "rotor_rate": rate}


@njit(cache=True)
def _motor(v, s):
    """Return T_mot: both phases, less the detents."""
    a = s[ALPHA]
    torque = v.k_m * (s[I_A] * np.sin(v.half_poles * a) + s[I_B] * np.cos(v.half_poles * a))
    torque -= v.detent_1 * np.sin(v.detent_order_1 * a + v.detent_phase_1)
    return torque - v.detent_2 * np.sin(v.detent_order_2 * a + v.detent_phase_2)


@njit(cache=True)
def _balance(v, voltages, angle):
    """Return the rotor's angle where coils and detents balance, by Newton's method from the commanded one."""
    s, torque = np.zeros(STATES), np.zeros(3)
    s[I_A], s[I_B] = v.U * voltages[0] / v.R, v.U * voltages[1] / v.R
    for _ in range(50):
        for n in range(3):
            s[ALPHA] = angle + (n - 1) * DIFFERENCE
            torque[n] = _motor(v, s)
        angle -= torque[1] * 2.0 * DIFFERENCE / (torque[2] - torque[0])
    return angle


@njit(cache=True)
def _gear(v, s):
    """Return the torque at the output, and that at the rotor."""
    angle = v.error_order * s[ALPHA] + v.error_phase
    slope = 1.0 / v.G + v.error * v.error_order * np.cos(angle)
    twist = s[ALPHA] / v.G + v.error * np.sin(angle) - s[OUT]
    torque = v.K_s * twist + v.D * (slope * s[OMEGA] - s[OUT_RATE])
    return torque, slope * torque


@njit(cache=True)
def _rates(v, s, held, mode, ds):
    """Write the states' rates; `mode` is 0 while the rotor sticks, else its direction."""
    a, w = v.half_poles * s[ALPHA], s[OMEGA]
    ds[I_A] = (v.U * held[0] - v.R * s[I_A] - v.k_m * w * np.sin(a)) / v.L
    ds[I_B] = (v.U * held[1] - v.R * s[I_B] - v.k_m * w * np.cos(a)) / v.L
    applied, reaction = _gear(v, s)
    resulting = 0.0
    if mode != 0:
        resulting = _motor(v, s) - mode * v.coulomb - v.viscous * w - reaction
    ds[ALPHA], ds[OMEGA] = w, resulting / v.J_rot
    pull_1 = v.w_1**2 * s[MODE] + 2.0 * v.zeta_1 * v.w_1 * s[MODE + 1]
    pull_2 = v.w_2**2 * s[MODE + 2] + 2.0 * v.zeta_2 * v.w_2 * s[MODE + 3]
    ds[OUT] = s[OUT_RATE]
    ds[OUT_RATE] = (applied + v.J_1 * pull_1 + v.J_2 * pull_2) / (v.J_m - v.J_1 - v.J_2)
    ds[MODE], ds[MODE + 1] = s[MODE + 1], -pull_1 - ds[OUT_RATE]
    ds[MODE + 2], ds[MODE + 3] = s[MODE + 3], -pull_2 - ds[OUT_RATE]
    ds[TABLE] = s[TABLE + 1]
    ds[TABLE + 1] = v.w_t**2 * (-(resulting + applied) - s[TABLE]) - 2.0 * v.zeta_t * v.w_t * s[TABLE + 1]
    seen = s[TABLE]
    for k in range(2):
        first, damping = FILTER + 2 * k, np.sin(np.pi * (2 * k + 1) / 8.0)
        ds[first] = s[first + 1]
        ds[first + 1] = v.w_c**2 * (seen - s[first]) - 2.0 * damping * v.w_c * s[first + 1]
        seen = s[first]


@njit(cache=True)
def _step(v, s, h, held, mode, out, work):
    """Write into `out` the state one Runge-Kutta step of fourth order later."""
    slope, inner = work
    out[:] = s
    inner[:] = s
    for stage in range(4):
        _rates(v, inner, held, mode, slope)
        weight = h / 6.0 if stage in (0, 3) else h / 3.0
        ahead = h if stage == 2 else 0.5 * h
        for n in range(STATES):
            out[n] += weight * slope[n]
            inner[n] = s[n] + ahead * slope[n]


@njit(cache=True)
def _ended(v, s, mode):
    """Tell whether the rotor's mode has ended: released, or come to rest."""
    if mode != 0:
        return mode * s[OMEGA] < 0.0
    return abs(_motor(v, s) - _gear(v, s)[1]) > v.static


@njit(cache=True)
def _advance(v, s, h, held, mode, after, work):
    """Carry the state over a step, with all switches in it, and return the mode behind it."""
    while h > 0.0:
        low, high, part, ended = 0.0, h, h, False
        for trial in range(BISECTIONS + 2):
            _step(v, s, part, held, mode, after, work)
            ended = _ended(v, after, mode)
            if ended:
                high = part
            elif trial == 0:
                break
            else:
                low = part
            part = 0.5 * (low + high) if trial < BISECTIONS else high
        s[:] = after
        if not ended:
            break
        if mode != 0:
            s[OMEGA] = 0.0
        pull = _motor(v, s) - _gear(v, s)[1]
        mode = 0 if abs(pull) <= v.static else int(np.sign(pull))
        h -= part
    return mode


@njit(cache=True)
def _run(v, edges, voltages, angle, interval, samples):
    s, after, work = np.zeros(STATES), np.zeros(STATES), np.zeros((2, STATES))
    torque, rate = np.empty(samples), np.empty(samples)
    s[I_A], s[I_B] = v.U * voltages[0, 0] / v.R, v.U * voltages[0, 1] / v.R
    s[ALPHA] = angle
    s[OUT] = angle / v.G + v.error * np.sin(v.error_order * angle + v.error_phase)
    t, edge, mode = 0.0, 0, 0
    for k in range(samples):
        due = k * interval
        while t < due:
            end = min(due, edges[edge]) if edge < edges.size else due
            parts = int(np.ceil((end - t) / STEP_S - 1e-9))
            for part in range(parts):
                h = (end - t) / (parts - part)
                mode = _advance(v, s, h, voltages[edge], mode, after, work)
                t += h
            t = end
            if edge < edges.size and end == edges[edge]:
                edge += 1
        torque[k], rate[k] = s[FILTER + 2], s[OMEGA]
    return torque, rate
