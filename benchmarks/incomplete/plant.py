"""The mechanism and all effects typed by hand: Runge-Kutta steps split at step edges; stick, slip, flanks located.

An effect whose size is 0 is absent. Nothing of mechid is used here: this is what its results are held against.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

STEP_S = 2.5e-5
"""Longest integration step."""
BISECTIONS = 48
"""Halvings of a step about a switch: to a few ulp."""
MOST_SWITCHES = 200
"""Within one step, at most; what is left of the step after them is left out."""
I_A, I_B, ALPHA, OMEGA, ALPHA_GEAR, OMEGA_GEAR, Z, Z_RATE, HYSTERESIS, CROSS, CROSS_RATE, AMPLIFIER, ALIAS = range(13)
LAG, STATES = 17, 18
"""Those above; from ALIAS on two second-order sections of the anti-alias filter; the lag of the detents."""
ROTOR, OUTPUT, FLANK = range(3)
"""Places of the modes. A flank's is the one that touches, 0 in the gap."""
FREE = 2
"""Mode of an output without friction; the others are 0 at rest, and the direction of sliding."""


class Values(NamedTuple):
    """The mechanism's values in SI units, angles in rad, and the sizes of its effects."""

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
    J_m: float
    K_res: float
    w_0: float
    zeta: float
    # a third detent; harmonic of the torque constant; half differences of the phases; their offsets in V
    detent_order_3: float = 1.0
    detent_3: float = 0.0
    detent_phase_3: float = 0.0
    harmonic_order: float = 3.0
    harmonic: float = 0.0
    harmonic_phase: float = 0.0
    r_R: float = 0.0
    r_L: float = 0.0
    r_k: float = 0.0
    offset_A: float = 0.0
    offset_B: float = 0.0
    # kinematic error at the output in rad; free travel in rad; Dahl's element beside the gear's spring
    kinematic_order: float = 1.0
    kinematic: float = 0.0
    kinematic_phase: float = 0.0
    backlash: float = 0.0
    hysteresis_stiffness: float = 0.0
    hysteresis_torque: float = 1.0
    # friction: at the output; Stribeck's speed; share of the transmitted torque; over an angle, of
    # the output, or of the rotor where that is 1
    output_coulomb: float = 0.0
    output_stiction: float = 0.0
    stribeck_rate: float = 0.0
    load_share: float = 0.0
    angle_share: float = 0.0
    angle_period: float = 1.0
    angle_phase: float = 0.0
    angle_of_rotor: float = 0.0
    # coils: loss of torque constant at U/R; resistance that rises in time; inductance over the angle; chopper in V
    saturation: float = 0.0
    warming: float = 0.0
    warming_s: float = 1.0
    inductance_share: float = 0.0
    # hysteresis of the detents: torque, and the electrical angle over which it builds up
    lag_torque: float = 0.0
    lag_angle: float = 1.0
    chopper: float = 0.0
    chopper_hz: float = 1000.0
    # the rig and its instruments: second mode; high-pass; Butterworth low-pass of order 2 or 4 (0: none)
    cross_gain: float = 0.0
    cross_w: float = 1.0
    cross_zeta: float = 0.0
    amplifier_s: float = 0.0
    alias_w: float = 0.0
    alias_order: float = 0.0


@njit(cache=True)
def _shape(v, x):
    """Return the torque constant's course over the electrical angle."""
    return np.sin(x) + v.harmonic * np.sin(v.harmonic_order * x + v.harmonic_phase)


@njit(cache=True)
def _inductance_slope(v, mean, x):
    """Return dL/dx of L = mean (1 + share cos 2x)."""
    return -2.0 * mean * v.inductance_share * np.sin(2.0 * x)


@njit(cache=True)
def _constant(v, side, i):
    """Return the torque constant of a phase at its current."""
    return v.k_m * (1.0 + side * v.r_k) * (1.0 - v.saturation * (i * v.R / v.U) ** 2)


@njit(cache=True)
def _motor(v, s):
    """Return T_mot: both phases with what their inductances add, less the detents."""
    a = s[ALPHA]
    x = v.half_poles * a
    y = x + 0.5 * np.pi
    torque = _constant(v, 1.0, s[I_A]) * s[I_A] * _shape(v, x) + _constant(v, -1.0, s[I_B]) * s[I_B] * _shape(v, y)
    if v.inductance_share != 0.0:
        slope_A = _inductance_slope(v, v.L * (1.0 + v.r_L), x)
        slope_B = _inductance_slope(v, v.L * (1.0 - v.r_L), y)
        torque += 0.5 * v.half_poles * (s[I_A] ** 2 * slope_A + s[I_B] ** 2 * slope_B)
    torque -= v.detent_1 * np.sin(v.detent_order_1 * a + v.detent_phase_1)
    torque -= v.detent_2 * np.sin(v.detent_order_2 * a + v.detent_phase_2)
    if v.detent_3 != 0.0:
        torque -= v.detent_3 * np.sin(v.detent_order_3 * a + v.detent_phase_3)
    return torque - v.lag_torque * s[LAG]


@njit(cache=True)
def _gear(v, s, flank):
    """Return the torque at the output, that at the rotor, and the rate of the twist, with a flank that touches.

    The flank is that of a whole step: a stage beyond its end must not meet the other one, whose damper jumps.
    """
    error = v.kinematic * np.sin(v.kinematic_order * s[ALPHA] + v.kinematic_phase)
    slope = v.kinematic * v.kinematic_order * np.cos(v.kinematic_order * s[ALPHA] + v.kinematic_phase)
    twist = s[ALPHA] / v.G + error - s[ALPHA_GEAR]
    rate = s[OMEGA] * (1.0 / v.G + slope) - s[OMEGA_GEAR]
    torque = s[HYSTERESIS]
    if flank != 0:
        torque += v.K_s * (twist - 0.5 * flank * v.backlash) + v.D * rate
    return torque, torque * (1.0 / v.G + slope), rate


@njit(cache=True)
def _uneven(v, s):
    """Return the factor of dry friction over the angle of the output or of the rotor."""
    angle = s[ALPHA] if v.angle_of_rotor == 1.0 else s[ALPHA_GEAR]
    return 1.0 + v.angle_share * np.sin(2.0 * np.pi * angle / v.angle_period + v.angle_phase)


@njit(cache=True)
def _pull(v, s, modes):
    """Return what friction has to hold at the rotor and at the output, each with the most that it holds."""
    output, rotor, _ = _gear(v, s, modes[FLANK])
    held = v.static * _uneven(v, s) + v.load_share * abs(rotor)
    return _motor(v, s) - rotor, held, output, v.output_coulomb + v.output_stiction


@njit(cache=True)
def _coils(v, t, s, held, ds):
    """Write the rates of the currents; `held` are both normalised voltages."""
    resistance = v.R * (1.0 + v.warming * (1.0 - np.exp(-t / v.warming_s)))
    peak = v.U + v.chopper * np.sin(2.0 * np.pi * v.chopper_hz * t)
    for phase in range(2):
        side = 1.0 - 2.0 * phase
        i, x = s[phase], v.half_poles * s[ALPHA] + 0.5 * np.pi * phase
        u = peak * held[phase] + (v.offset_A if phase == 0 else v.offset_B)
        inductance = v.L * (1.0 + side * v.r_L)
        per_speed = _constant(v, side, i) * _shape(v, x)
        if v.inductance_share != 0.0:
            per_speed += i * v.half_poles * _inductance_slope(v, inductance, x)
            inductance *= 1.0 + v.inductance_share * np.cos(2.0 * x)
        ds[phase] = (u - resistance * (1.0 + side * v.r_R) * i - per_speed * s[OMEGA]) / inductance


@njit(cache=True)
def _friction(v, s, rotor):
    """Return dry friction at the rotor while it slides."""
    level = v.coulomb
    if v.stribeck_rate > 0.0:
        level += (v.static - v.coulomb) * np.exp(-((s[OMEGA] / v.stribeck_rate) ** 2))
    return level * _uneven(v, s) + v.load_share * abs(rotor)


@njit(cache=True)
def _rates(v, t, s, held, modes, ds):
    """Write the states' rates, and return what is recorded."""
    _coils(v, t, s, held, ds)
    output, rotor, twist_rate = _gear(v, s, modes[FLANK])
    resulting = 0.0
    if modes[ROTOR] != 0:
        resulting = _motor(v, s) - modes[ROTOR] * _friction(v, s, rotor) - v.viscous * s[OMEGA] - rotor
    applied = 0.0 if modes[OUTPUT] == 0 else output - modes[OUTPUT] * v.output_coulomb
    ds[ALPHA] = s[OMEGA]
    ds[OMEGA] = resulting / v.J_rot
    ds[ALPHA_GEAR] = s[OMEGA_GEAR]
    ds[OMEGA_GEAR] = applied / v.J_m
    ds[Z] = s[Z_RATE]
    ds[Z_RATE] = v.w_0**2 * (v.K_res * resulting - s[Z]) - 2.0 * v.zeta * v.w_0 * s[Z_RATE]
    ds[HYSTERESIS] = v.hysteresis_stiffness * (twist_rate - abs(twist_rate) * s[HYSTERESIS] / v.hysteresis_torque)
    ds[LAG] = v.half_poles * (s[OMEGA] - abs(s[OMEGA]) * s[LAG]) / v.lag_angle
    total = v.cross_gain * (resulting + applied)
    ds[CROSS] = s[CROSS_RATE]
    ds[CROSS_RATE] = v.cross_w**2 * (total - s[CROSS]) - 2.0 * v.cross_zeta * v.cross_w * s[CROSS_RATE]
    return _instruments(v, s, -(s[Z] + applied) - s[CROSS], ds)


@njit(cache=True)
def _instruments(v, s, seen, ds):
    """Write the rates of charge amplifier and anti-alias filter, and return what they make of the torque."""
    ds[AMPLIFIER] = 0.0
    if v.amplifier_s > 0.0:
        ds[AMPLIFIER] = (seen - s[AMPLIFIER]) / v.amplifier_s
        seen -= s[AMPLIFIER]
    order = int(v.alias_order)
    for k in range(order // 2):
        damping = np.sin(np.pi * (2 * k + 1) / (2 * order))
        first = ALIAS + 2 * k
        ds[first] = s[first + 1]
        ds[first + 1] = v.alias_w**2 * (seen - s[first]) - 2.0 * damping * v.alias_w * s[first + 1]
        seen = s[first]
    return seen


@njit(cache=True)
def _step(v, t, s, h, held, modes, out, work):
    """Write into `out` the state one Runge-Kutta step of fourth order later."""
    slope, inner = work
    out[:] = s
    inner[:] = s
    for stage in range(4):
        node = 0.5 * h * ((stage + 1) // 2)
        _rates(v, t + node, inner, held, modes, slope)
        weight = h / 6.0 if stage in (0, 3) else h / 3.0
        ahead = h if stage == 2 else 0.5 * h
        for n in range(STATES):
            out[n] += weight * slope[n]
            inner[n] = s[n] + ahead * slope[n]


@njit(cache=True)
def _ended(v, s, modes):
    """Tell of rotor and output whether their mode has ended: released, or come to rest."""
    pull, held, pull_output, held_output = _pull(v, s, modes)
    rotor = abs(pull) > held if modes[ROTOR] == 0 else modes[ROTOR] * s[OMEGA] < 0.0
    output = False
    if held_output > 0.0:
        output = abs(pull_output) > held_output if modes[OUTPUT] == 0 else modes[OUTPUT] * s[OMEGA_GEAR] < 0.0
    return rotor, output


@njit(cache=True)
def _mode(pull, held):
    """Return how a body at rest goes on: held, or released in the direction of the pull."""
    return 0 if abs(pull) <= held else int(np.sign(pull))


@njit(cache=True)
def _switched(v, s, rotor, output, modes):
    """Stop what has come to rest, and write how what has ended a mode goes on, and which flank touches."""
    modes[FLANK] = _flank(v, s)
    if rotor and modes[ROTOR] != 0:
        s[OMEGA] = 0.0
    if output and modes[OUTPUT] != 0:
        s[OMEGA_GEAR] = 0.0
    pull, held, pull_output, held_output = _pull(v, s, modes)
    if rotor:
        modes[ROTOR] = _mode(pull, held)
    if output:
        modes[OUTPUT] = _mode(pull_output, held_output)


@njit(cache=True)
def _flank(v, s):
    """Return which flank of a gear with backlash touches, 0 in the gap: at a contact with speed its torque jumps."""
    if v.backlash == 0.0:
        return 1
    error = v.kinematic * np.sin(v.kinematic_order * s[ALPHA] + v.kinematic_phase)
    twist = s[ALPHA] / v.G + error - s[ALPHA_GEAR]
    return int(twist >= 0.5 * v.backlash) - int(twist <= -0.5 * v.backlash)


@njit(cache=True)
def _until_switch(v, t, s, h, held, modes, after, work):
    """Write the state after a step, or after the part of it up to the first switch; return the part and who switches.

    The first trial is the whole step, then it is halved about the switch, and the last is just past it.
    """
    low, high, part = 0.0, h, h
    rotor, output, gear = False, False, False
    for trial in range(BISECTIONS + 2):
        _step(v, t, s, part, held, modes, after, work)
        rotor, output = _ended(v, after, modes)
        gear = _flank(v, after) != modes[FLANK]
        if rotor or output or gear:
            high = part
        elif trial == 0:
            break
        else:
            low = part
        part = 0.5 * (low + high) if trial < BISECTIONS else high
    return part, rotor, output, gear


@njit(cache=True)
def _advance(v, t, s, h, held, modes, after, work):
    """Carry the state over a step, with all switches in it: between stick and slip, and of the gear's flanks."""
    for _ in range(MOST_SWITCHES):
        part, rotor, output, gear = _until_switch(v, t, s, h, held, modes, after, work)
        s[:] = after
        if not (rotor or output or gear):
            break
        _switched(v, s, rotor, output, modes)
        t += part
        h -= part
        if h <= 0.0:
            break


@njit(cache=True)
def _begin(v, start_angle, voltages, s, modes):
    """Write the state at rest: currents settled, rotor at the commanded angle, gear unwound."""
    s[I_A] = (v.U * voltages[0] + v.offset_A) / (v.R * (1.0 + v.r_R))
    s[I_B] = (v.U * voltages[1] + v.offset_B) / (v.R * (1.0 - v.r_R))
    s[ALPHA] = start_angle / v.half_poles
    s[ALPHA_GEAR] = s[ALPHA] / v.G + v.kinematic * np.sin(v.kinematic_order * s[ALPHA] + v.kinematic_phase)
    modes[FLANK] = _flank(v, s)
    pull, held, pull_output, held_output = _pull(v, s, modes)
    modes[ROTOR] = _mode(pull, held)
    modes[OUTPUT] = _mode(pull_output, held_output) if held_output > 0.0 else FREE


def run(
    values: Values,
    edges: np.ndarray,
    voltages: np.ndarray,
    start_angle: float,
    interval: float,
    samples: int,
    delay: float = 0.0,
) -> np.ndarray:
    """Return the recorded torque, (samples,) N m, one sample every `interval` s from `delay` before the start.

    Parameters
    ----------
    values : Values
    edges, voltages : (E,) s and (E + 1, 2)
        As `stepping.edges` returns them.
    start_angle : float
        Electrical angle in rad at which the coils hold the rotor at the start.
    interval : float
        Of the samples, s.
    samples : int
    delay : float
        How long the recorder runs before the mechanism is let go and the command starts, s; until then it rests.
    """
    record = np.array([tuple(values)], dtype=[(name, np.float64) for name in Values._fields])[0]
    return _run(record, edges, voltages, start_angle, interval, samples, delay)


@njit(cache=True)
def _run(v, edges, voltages, start_angle, interval, samples, delay):
    s, after, work = np.zeros(STATES), np.zeros(STATES), np.zeros((2, STATES))
    modes = np.zeros(3, np.int64)
    out = np.empty(samples)
    _begin(v, start_angle, voltages[0], s, modes)
    t, edge = 0.0, 0
    for k in range(samples):
        due = k * interval - delay
        while t < due:
            held = voltages[edge]
            end = min(due, edges[edge]) if edge < edges.size else due
            parts = int(np.ceil((end - t) / STEP_S - 1e-9))
            for part in range(parts):
                h = (end - t) / (parts - part)
                _advance(v, t, s, h, held, modes, after, work)
                t += h
            t = end
            if edge < edges.size and end == edges[edge]:
                edge += 1
        held = voltages[edge]
        out[k] = _rates(v, t, s, held, modes, work[0])
    return out
