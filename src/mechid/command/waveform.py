"""Normalised phase voltages of a step: the VST block of the paper, without its peak voltage."""

from __future__ import annotations

import math
from typing import Literal, TypeAlias

import numpy as np

from mechid.arrays import FloatArray, IntArray

Waveform: TypeAlias = Literal["cosine", "square"]
WAVEFORMS: tuple[Waveform, ...] = ("cosine", "square")

SMALLEST_DEG = 1e-12
"""An angle this close to a multiple of 90 deg is taken as that multiple: start and step angles are rounded."""


def phase_voltages(index: IntArray, steps_per_full_step: int, start_angle_deg: float, waveform: Waveform) -> FloatArray:
    """Return e_A = -cos(theta_k) and e_B = sin(theta_k), or their signs for a square wave.

    The electrical angle is theta_k = theta_0 + k 90deg/n ([Kornienko2013]_, voltage stepping). The index is reduced
    modulo a turn first, in integers, so that a high index is as exact as index 0, and both voltages are exactly zero
    where they should be.

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

    Returns
    -------
    (E, 2) float
        e_A and e_B, dimensionless; the peak voltage times these is u_A and u_B.
    """
    turned = (index % (4 * steps_per_full_step)) * 90.0 / steps_per_full_step
    cosine, sine = cosine_and_sine(math.fmod(start_angle_deg, 360.0) + turned)
    # Adding 0.0 turns negative zeros into zeros.
    voltages = np.stack([-cosine, sine], axis=-1) + 0.0
    return np.sign(voltages) if waveform == "square" else voltages


def cosine_and_sine(angle_deg: FloatArray) -> tuple[FloatArray, FloatArray]:
    # Only the remainder within 45 deg of a quarter turn goes through cos and sin: np.cos(pi / 2) is not 0, but
    # np.sin(0) is, which makes the multiples of 90 deg exact.
    """Return cosine and sine of angles in degrees, exact at the multiples of 90 deg, each (E,)."""
    quarter = np.rint(angle_deg / 90.0)
    rest_deg = angle_deg - 90.0 * quarter
    rest = np.deg2rad(np.where(np.abs(rest_deg) < SMALLEST_DEG, 0.0, rest_deg))
    turns = quarter.astype(np.int64) % 4
    cosine, sine = np.cos(rest), np.sin(rest)
    return (
        np.choose(turns, [cosine, -sine, -cosine, sine]),
        np.choose(turns, [sine, cosine, -sine, -cosine]),
    )
