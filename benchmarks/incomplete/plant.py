"""The mechanism and all effects typed by hand: Runge-Kutta steps split at the step edges, stick and slip located.

An effect whose size is 0 is absent. Nothing of mechid is used here: this is what its results are held against.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

STEP_S = 2.5e-5
"""Longest integration step."""
BISECTIONS = 48
MOST_SWITCHES = 200
"""Of stick and slip within one step; beyond it the last mode stands to the step's end."""
I_A, I_B, ALPHA, OMEGA, ALPHA_GEAR, OMEGA_GEAR, Z, Z_RATE, HYSTERESIS, CROSS, CROSS_RATE, AMPLIFIER, ALIAS = range(13)
STATES = 17
"""Those above and, from ALIAS on, two second-order sections of the anti-alias filter."""


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
    # friction: at the output; Stribeck's speed; share of the transmitted torque; over the output's angle
    output_coulomb: float = 0.0
    output_stiction: float = 0.0
    stribeck_rate: float = 0.0
    load_share: float = 0.0
    angle_share: float = 0.0
    angle_period: float = 1.0
    angle_phase: float = 0.0
    # coils: loss of torque constant at U/R; resistance that rises in time; inductance over the angle; chopper in V
    saturation: float = 0.0
    warming: float = 0.0
    warming_s: float = 1.0
    inductance_share: float = 0.0
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
    return torque


@njit(cache=True)
def _gear(v, s):
    """Return the torque at the output, that at the rotor, and the rate of the twist."""
    error = v.kinematic * np.sin(v.kinematic_order * s[ALPHA] + v.kinematic_phase)
    slope = v.kinematic * v.kinematic_order * np.cos(v.kinematic_order * s[ALPHA] + v.kinematic_phase)
    twist = s[ALPHA] / v.G + error - s[ALPHA_GEAR]
    rate = s[OMEGA] * (1.0 / v.G + slope) - s[OMEGA_GEAR]
    half = 0.5 * v.backlash
    torque = 0.0
    if twist >= half:
        torque = v.K_s * (twist - half) + v.D * rate
    elif twist <= -half:
        torque = v.K_s * (twist + half) + v.D * rate
    torque += s[HYSTERESIS]
    return torque, torque * (1.0 / v.G + slope), rate


@njit(cache=True)
def _uneven(v, s):
    """Return the factor of dry friction over the output's angle."""
    return 1.0 + v.angle_share * np.sin(2.0 * np.pi * s[ALPHA_GEAR] / v.angle_period + v.angle_phase)


@njit(cache=True)
def _pull(v, s):
    """Return what friction has to hold at the rotor and at the output, each with the most that it holds."""
    output, rotor, _ = _gear(v, s)
    held = v.static * _uneven(v, s) + v.load_share * abs(rotor)
    return _motor(v, s) - rotor, held, output, v.output_coulomb + v.output_stiction


@njit(cache=True)
def _rates(v, t, s, u_A, u_B, mode, mode_output, ds):
    """Write the states' rates, and return what the transducer sees, before its filters."""
    x = v.half_poles * s[ALPHA]
    warm = 1.0 + v.warming * (1.0 - np.exp(-t / v.warming_s))
    ripple = v.chopper * np.sin(2.0 * np.pi * v.chopper_hz * t)
    for phase in range(2):
        side = 1.0 - 2.0 * phase
        u = v.U * (u_A if phase == 0 else u_B)
        u += (v.offset_A if phase == 0 else v.offset_B) + ripple * (u_A if phase == 0 else u_B)
        i = s[phase]
        angle = x + 0.5 * np.pi * phase
        mean = v.L * (1.0 + side * v.r_L)
        inductance = mean * (1.0 + v.inductance_share * np.cos(2.0 * angle)) if v.inductance_share != 0.0 else mean
        motion = _constant(v, side, i) * _shape(v, angle)
        if v.inductance_share != 0.0:
            motion += i * v.half_poles * _inductance_slope(v, mean, angle)
        ds[phase] = (u - v.R * (1.0 + side * v.r_R) * warm * i - motion * s[OMEGA]) / inductance
    output, rotor, twist_rate = _gear(v, s)
    resulting = 0.0
    if mode != 0:
        level = v.coulomb
        if v.stribeck_rate > 0.0:
            level += (v.static - v.coulomb) * np.exp(-((s[OMEGA] / v.stribeck_rate) ** 2))
        friction = mode * (level * _uneven(v, s) + v.load_share * abs(rotor)) + v.viscous * s[OMEGA]
        resulting = _motor(v, s) - friction - rotor
    applied = 0.0 if mode_output == 0 else output - mode_output * v.output_coulomb
    ds[ALPHA] = s[OMEGA]
    ds[OMEGA] = resulting / v.J_rot
    ds[ALPHA_GEAR] = s[OMEGA_GEAR]
    ds[OMEGA_GEAR] = applied / v.J_m
    ds[Z] = s[Z_RATE]
    ds[Z_RATE] = v.w_0**2 * (v.K_res * resulting - s[Z]) - 2.0 * v.zeta * v.w_0 * s[Z_RATE]
    ds[HYSTERESIS] = v.hysteresis_stiffness * (twist_rate - abs(twist_rate) * s[HYSTERESIS] / v.hysteresis_torque)
    total = v.cross_gain * (resulting + applied)
    ds[CROSS] = s[CROSS_RATE]
    ds[CROSS_RATE] = v.cross_w**2 * (total - s[CROSS]) - 2.0 * v.cross_zeta * v.cross_w * s[CROSS_RATE]
    seen = -(s[Z] + applied) - s[CROSS]
    recorded = seen
    ds[AMPLIFIER] = 0.0
    if v.amplifier_s > 0.0:
        ds[AMPLIFIER] = (seen - s[AMPLIFIER]) / v.amplifier_s
        recorded = seen - s[AMPLIFIER]
    order = int(v.alias_order)
    for k in range(order // 2):
        damping = np.sin(np.pi * (2 * k + 1) / (2 * order))
        first = ALIAS + 2 * k
        ds[first] = s[first + 1]
        ds[first + 1] = v.alias_w**2 * (recorded - s[first]) - 2.0 * damping * v.alias_w * s[first + 1]
        recorded = s[first]
    return recorded


@njit(cache=True)
def _step(v, t, s, h, u_A, u_B, mode, mode_output, out, work):
    """Write into `out` the state one Runge-Kutta step of fourth order later."""
    k_1, k_2, k_3, k_4, inner = work
    _rates(v, t, s, u_A, u_B, mode, mode_output, k_1)
    inner[:] = s + 0.5 * h * k_1
    _rates(v, t + 0.5 * h, inner, u_A, u_B, mode, mode_output, k_2)
    inner[:] = s + 0.5 * h * k_2
    _rates(v, t + 0.5 * h, inner, u_A, u_B, mode, mode_output, k_3)
    inner[:] = s + h * k_3
    _rates(v, t + h, inner, u_A, u_B, mode, mode_output, k_4)
    out[:] = s + h / 6.0 * (k_1 + 2.0 * k_2 + 2.0 * k_3 + k_4)


@njit(cache=True)
def _ended(v, s, mode, mode_output):
    """Tell of rotor and output whether their mode has ended: released, or come to rest."""
    pull, held, pull_output, held_output = _pull(v, s)
    rotor = abs(pull) > held if mode == 0 else mode * s[OMEGA] < 0.0
    output = False
    if held_output > 0.0:
        output = abs(pull_output) > held_output if mode_output == 0 else mode_output * s[OMEGA_GEAR] < 0.0
    return rotor, output


@njit(cache=True)
def _advance(v, t, s, h, u_A, u_B, modes, after, work):
    """Carry the state over a step, each switch between stick and slip met where it happens."""
    for _ in range(MOST_SWITCHES):
        _step(v, t, s, h, u_A, u_B, modes[0], modes[1], after, work)
        rotor, output = _ended(v, after, modes[0], modes[1])
        if not (rotor or output):
            break
        low, high = 0.0, h
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            _step(v, t, s, middle, u_A, u_B, modes[0], modes[1], after, work)
            rotor, output = _ended(v, after, modes[0], modes[1])
            if rotor or output:
                high = middle
            else:
                low = middle
        _step(v, t, s, high, u_A, u_B, modes[0], modes[1], after, work)
        rotor, output = _ended(v, after, modes[0], modes[1])
        s[:] = after
        if rotor and modes[0] != 0:
            s[OMEGA] = 0.0
        if output and modes[1] != 0:
            s[OMEGA_GEAR] = 0.0
        pull, held, pull_output, held_output = _pull(v, s)
        if rotor:
            modes[0] = 0 if abs(pull) <= held else int(np.sign(pull))
        if output:
            modes[1] = 0 if abs(pull_output) <= held_output else int(np.sign(pull_output))
        t += high
        h -= high
        if h <= 0.0:
            return
    s[:] = after


@njit(cache=True)
def _begin(v, start_angle, u_A, u_B, s, modes):
    """Write the state at rest: currents settled, rotor at the commanded angle, gear unwound."""
    s[I_A] = (v.U * u_A + v.offset_A) / (v.R * (1.0 + v.r_R))
    s[I_B] = (v.U * u_B + v.offset_B) / (v.R * (1.0 - v.r_R))
    s[ALPHA] = start_angle / v.half_poles
    s[ALPHA_GEAR] = s[ALPHA] / v.G + v.kinematic * np.sin(v.kinematic_order * s[ALPHA] + v.kinematic_phase)
    pull, held, pull_output, held_output = _pull(v, s)
    modes[0] = 0 if abs(pull) <= held else int(np.sign(pull))
    modes[1] = 2
    if held_output > 0.0:
        modes[1] = 0 if abs(pull_output) <= held_output else int(np.sign(pull_output))


@njit(cache=True)
def run(v, edges, voltages, start_angle, interval, samples, longest):
    """Return the recorded torque, (samples,) N m, one sample every `interval` s from 0.

    Parameters
    ----------
    v : Values
    edges, voltages : (E,) s and (E + 1, 2)
        As `stepping.edges` returns them.
    start_angle : float
        Electrical angle in rad at which the coils hold the rotor at the start.
    interval, longest : float
        Of the samples, and the longest integration step, s.
    samples : int
    """
    s, after, work = np.zeros(STATES), np.zeros(STATES), np.zeros((5, STATES))
    modes = np.zeros(2, np.int64)
    out = np.empty(samples)
    _begin(v, start_angle, voltages[0, 0], voltages[0, 1], s, modes)
    t, edge = 0.0, 0
    for k in range(samples):
        due = k * interval
        while t < due:
            held = voltages[edge]
            end = min(due, edges[edge]) if edge < edges.size else due
            parts = int(np.ceil((end - t) / longest - 1e-9))
            for part in range(parts):
                h = (end - t) / (parts - part)
                _advance(v, t, s, h, held[0], held[1], modes, after, work)
                t += h
            t = end
            if edge < edges.size and end == edges[edge]:
                edge += 1
        held = voltages[edge]
        out[k] = _rates(v, t, s, held[0], held[1], modes[0], modes[1], work[0])
    return out
