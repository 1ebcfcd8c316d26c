"""Magnitude and phase columns of a response: units, and detection of values that contradict the header."""

from __future__ import annotations

import math
import re

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.errors import InputFileError
from mechid.structure.checks import NONCAUSAL_SHARE, energy_before_impulse

LINEAR = "write it as 10^(dB/20), in a unit as rad/(N*m)"
_DECIBEL = re.compile(r"(?<![A-Za-z])dB(?![A-Za-z])", re.IGNORECASE)
LEAST_PHASE_SPAN = 1.0
"""Least change of the phase at a resonance, as a number in degrees or radians."""
PEAK_RATIO = 3.0
"""Ratio by which a magnitude falls on both sides of a resonance, whose phase changes by 90 deg or more."""
HALF_TURN_TOLERANCE = 1e-3
"""Tolerance for the largest phase to count as half a turn, pi."""
CAUSAL_SHARE = 0.01
"""Maximum share of the impulse response's energy before the impulse, for a causal response on a fine grid."""
LEAST_POINTS, HIGHEST_DB = 16, 400.0
"""Minimum number of points of the causality test; maximum number that may be a level in dB."""
LARGEST_RADIANS = 100.0
"""Maximum phase in radians; more than 16 turns would need more modes than a response shows."""


def is_decibel(text: str | None) -> bool:
    """Return whether a unit, or the suffix of a column's name, denotes a level in dB.

    Examples
    --------
    >>> is_decibel("dB"), is_decibel("dB re 1 rad/(N m)"), is_decibel("los_x_mag_db"), is_decibel("rad/(N*m)")
    (True, True, True, False)
    """
    return text is not None and any(map(_DECIBEL.fullmatch, re.split(r"[\s_()]+", text)))


def from_polar(magnitude: FloatArray, phase_rad: FloatArray) -> ComplexArray:
    """Return complex numbers, (n,), from magnitudes and phases in rad."""
    return np.asarray(magnitude * np.exp(1j * phase_rad), dtype=np.complex128)


def refuse_levels(magnitude: FloatArray, unit: str | None, place: str) -> None:
    """Raise an error for magnitudes in dB, recognised by their unit or by a negative value.

    Raises
    ------
    InputFileError
        The magnitudes are levels in dB.
    """
    if is_decibel(unit):
        raise InputFileError(f'{place}: has unit "{unit}", a level; {LINEAR}')
    if np.min(magnitude, initial=0.0) < 0.0:
        raise InputFileError(
            f"{place}: found {float(magnitude.min()):.6g}, but a magnitude is 0 or above; if it is a level in dB, "
            f"{LINEAR}"
        )


def refuse_hidden_levels(frequency_hz: FloatArray, magnitude: FloatArray, phase_rad: FloatArray, place: str) -> None:
    """Raise an error for positive magnitudes without a unit that are levels in dB.

    The response of a linear system is causal. The values are taken for levels if they give a causal response as levels
    but not as magnitudes.

    Raises
    ------
    InputFileError
        The magnitudes are levels in dB.
    """
    if magnitude.size < LEAST_POINTS or not np.all(np.diff(frequency_hz) > 0.0) or magnitude.max() > HIGHEST_DB:
        return
    read = energy_before_impulse(frequency_hz, from_polar(magnitude, phase_rad))
    meant = energy_before_impulse(frequency_hz, from_polar(10.0 ** (magnitude / 20.0), phase_rad))
    if read > NONCAUSAL_SHARE and meant < CAUSAL_SHARE:
        raise InputFileError(
            f"{place}: with its phase, this is a causal response if it is a level in dB, but not if it is a magnitude; "
            f"{LINEAR}, or state the unit in brackets"
        )


def phase_in_radians(phase: FloatArray, unit: str, magnitude: FloatArray, place: str, *, is_stated: bool) -> FloatArray:
    """Return a phase in rad, (n,).

    Parameters
    ----------
    phase : (n,)
    unit : {"deg", "rad"}
    magnitude : (n,)
        Magnitude of the same response.
    place : str
        Location in the file, for messages.
    is_stated : bool
        Whether the unit is stated in brackets, in which case it is trusted. A suffix of the column's name is not: it
        may have been chosen only because mechid requires one.

    Raises
    ------
    InputFileError
        The phase may be in the other unit.
    """
    largest = float(np.max(np.abs(phase), initial=0.0))
    if unit == "deg":
        if not is_stated and _looks_like_radians(phase, magnitude):
            raise _ambiguous_unit_error(
                place, f"all phases are within +-{largest:.6g}; in degrees a resonance would turn them further", "rad"
            )
        return np.radians(phase)
    if not is_stated and largest > LARGEST_RADIANS:
        raise _ambiguous_unit_error(place, f"found {largest:.6g}, many turns if in radians", "deg")
    return phase


def _ambiguous_unit_error(place: str, why: str, other: str) -> InputFileError:
    own = "deg" if other == "rad" else "rad"
    return InputFileError(
        f"{place}: {why}; end the name with _phase [{other}] if that is the unit, with _phase [{own}] if not"
    )


def _looks_like_radians(phase: FloatArray, magnitude: FloatArray) -> bool:
    """Return whether a phase declared in degrees must be in radians.

    This is the case if it is within half a turn in radians, and either changes at a resonance or reaches half a turn.
    """
    largest = float(np.max(np.abs(phase), initial=0.0))
    if largest > math.pi + HALF_TURN_TOLERANCE:
        return False
    turns = float(np.ptp(phase)) > LEAST_PHASE_SPAN and _has_resonance(magnitude)
    return turns or abs(largest - math.pi) < HALF_TURN_TOLERANCE


def _has_resonance(magnitude: FloatArray) -> bool:
    """Return whether a magnitude has a maximum from which it falls by `PEAK_RATIO` on both sides."""
    # Running minima from both ends: the larger one is how far the magnitude has fallen on the shallower side.
    before = np.minimum.accumulate(magnitude)
    after = np.minimum.accumulate(magnitude[::-1])[::-1]
    return bool(np.any(magnitude > PEAK_RATIO * np.maximum(before, after)))
