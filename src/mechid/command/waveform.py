"""Normalised phase voltages of a step: the VST block of the paper, without its peak voltage."""

from __future__ import annotations

import math
from typing import Literal, TypeAlias

import numpy as np

from mechid.arrays import FloatArray, IntArray

Waveform: TypeAlias = Literal["cosine", "square"]
WAVEFORMS: tuple[Waveform, ...] = ("cosine", "square")

SHIFTS_DEG = (0.0, 120.0, 240.0)
"""Electrical angle of each of three phases."""
SMALLEST_DEG = 1e-12
"""An angle this close to a multiple of 90 deg is taken as that multiple: start and step angles are rounded."""


def phase_voltages(
    index: IntArray, steps_per_full_step: int, start_angle_deg: float, waveform: Waveform, phases: int = 2
) -> FloatArray:
    """Return e_A = -cos(theta_k) and e_B = sin(theta_k), or their signs for a square wave.

    The electrical angle is theta_k = theta_0 + k 90deg/n ([Kornienko2013]_, voltage stepping), with three phases
    theta_0 + k 60deg/n. The index is reduced modulo a turn first, in integers, so that a high index is as exact as
    index 0, and both voltages are exactly zero where they should be.

    Parameters
    ----------
    index : (E,) int
        Step indices k.
    steps_per_full_step : int
        n.
    start_angle_deg : float
        theta_0 in degrees, electrical.
    waveform : {"cosine", "square"}
        "square" is a driver's output in full and half stepping: 0 where the cosine is 0.
    phases : {2, 3, 4}
        With 3 in star the result is on the axes of Clarke's transform: of -cos(theta_k + shift_X), or its signs.

    Returns
    -------
    (E, 2) float
        e_A and e_B, dimensionless; the peak voltage times these is u_A and u_B.
    """
    count = steps_per_period(phases)
    turned = (index % (count * steps_per_full_step)) * (360.0 / count) / steps_per_full_step
    angle_deg = math.fmod(start_angle_deg, 360.0) + turned
    if waveform == "square" and phases == 3:
        signs = [np.sign(-cosine_and_sine(angle_deg + shift)[0]) for shift in SHIFTS_DEG]
        return star_axes(np.stack(signs, axis=-1))
    cosine, sine = cosine_and_sine(angle_deg)
    # Adding 0.0 turns negative zeros into zeros.
    voltages = np.stack([-cosine, sine], axis=-1) + 0.0
    return np.sign(voltages) if waveform == "square" else voltages


def steps_per_period(phases: int) -> int:
    """Return the full steps of an electrical period: 4, or the 6 states of three phases."""
    return 6 if phases == 3 else 4


def star_axes(terminals: FloatArray) -> FloatArray:
    """Return the two axes of three phases in star, (E, 2), from the voltages of their terminals, (E, 3).

    e_A = 2/3 sum e_X cos(shift_X), e_B = 2/3 sum e_X sin(shift_X) (Clarke). The star point is free: a part that the
    three have in common drives no current, and has none here.

    Examples
    --------
    >>> star_axes(np.array([[1.0, -0.5, -0.5], [1.0, 1.0, 1.0]]))
    array([[1., 0.],
           [0., 0.]])
    """
    a, b, c = terminals[:, 0], terminals[:, 1], terminals[:, 2]
    axes: FloatArray = np.stack([(2.0 * a - b - c) / 3.0, (b - c) / math.sqrt(3.0)], axis=-1)
    return axes


def cosine_and_sine(angle_deg: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return cosine and sine of angles in degrees, exact at the multiples of 90 deg, each (E,)."""
    # Only the remainder within 45 deg of a quarter turn goes through cos and sin: np.cos(pi / 2) is not 0, but
    # np.sin(0) is, which makes the multiples of 90 deg exact.
    quarter = np.rint(angle_deg / 90.0)
    rest_deg = angle_deg - 90.0 * quarter
    rest = np.deg2rad(np.where(np.abs(rest_deg) < SMALLEST_DEG, 0.0, rest_deg))
    turns = quarter.astype(np.int64) % 4
    cosine, sine = np.cos(rest), np.sin(rest)
    return (
        np.choose(turns, [cosine, -sine, -cosine, sine]),
        np.choose(turns, [sine, cosine, -sine, -cosine]),
    )
