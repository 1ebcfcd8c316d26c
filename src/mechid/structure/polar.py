"""Magnitude and phase columns of a response: their units, and what shows that they are not what the header says."""

from __future__ import annotations

import math
import re

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.errors import InputFileError
from mechid.structure.checks import NOT_CAUSAL, energy_before

LINEAR = "write it as 10^(dB/20), in a unit as rad/(N*m)"
_DECIBEL = re.compile(r"(?<![A-Za-z])dB(?![A-Za-z])", re.IGNORECASE)
TURN_TO_ASK = 1.0
"""Phase in the numbers of the file by which a resonance turns at least, in degrees and in radians."""
PEAK = 3.0
"""A magnitude that falls so far on either side of a maximum has a resonance: its phase turns by 90 deg or more."""
HALF_TURN = 1e-3
"""How near to pi the largest phase is to be taken for half a turn."""
CAUSAL = 0.01
"""Share of the impulse response's energy before the impulse that a response on a fine grid stays below."""
FEWEST, HIGHEST_DB = 16, 400.0
"""Points of a response that tell whether it is causal; a larger number is no level."""
LARGEST_RADIANS = 100.0
"""A phase of more turns than 16 would be that of more modes than a response shows."""


def is_decibel(text: str | None) -> bool:
    """Whether a unit, or the end of a column's name, is that of a level.

    Examples
    --------
    >>> is_decibel("dB"), is_decibel("dB re 1 rad/(N m)"), is_decibel("los_x_mag_db"), is_decibel("rad/(N*m)")
    (True, True, True, False)
    """
    return text is not None and any(map(_DECIBEL.fullmatch, re.split(r"[\s_()]+", text)))


def from_polar(magnitude: FloatArray, phase_rad: FloatArray) -> ComplexArray:
    """Return complex numbers, (n,)."""
    return np.asarray(magnitude * np.exp(1j * phase_rad), dtype=np.complex128)


def refuse_levels(magnitude: FloatArray, unit: str | None, place: str) -> None:
    """Refuse magnitudes in dB: where the unit says so, or where one is below 0.

    Raises
    ------
    InputFileError
        They are.
    """
    if is_decibel(unit):
        raise InputFileError(f'{place}: has unit "{unit}", a level; {LINEAR}')
    if np.min(magnitude, initial=0.0) < 0.0:
        raise InputFileError(
            f"{place}: found {float(magnitude.min()):.6g}, and a magnitude is 0 or above; if it is a level in dB, "
            f"{LINEAR}"
        )


def refuse_hidden_levels(frequency_hz: FloatArray, magnitude: FloatArray, phase_rad: FloatArray, place: str) -> None:
    """Refuse magnitudes without a unit that are levels in dB, all above 0.

    Of a linear system the response begins with the impulse: as levels these do, as magnitudes they do not.

    Raises
    ------
    InputFileError
        They are.
    """
    if magnitude.size < FEWEST or not np.all(np.diff(frequency_hz) > 0.0) or magnitude.max() > HIGHEST_DB:
        return
    read = energy_before(frequency_hz, from_polar(magnitude, phase_rad))
    meant = energy_before(frequency_hz, from_polar(10.0 ** (magnitude / 20.0), phase_rad))
    if read > NOT_CAUSAL and meant < CAUSAL:
        raise InputFileError(
            f"{place}: with the phase beside it this is the response of a structure if it is a level in dB, and of "
            f"none if it is a magnitude; {LINEAR}, or state the unit in brackets"
        )


def phase_in_radians(phase: FloatArray, unit: str, magnitude: FloatArray, place: str, *, is_stated: bool) -> FloatArray:
    """Return a phase in rad, (n,).

    Parameters
    ----------
    phase : (n,)
    unit : {"deg", "rad"}
    magnitude : (n,)
        Beside it.
    place : str
        For messages.
    is_stated : bool
        Whether the unit stands in brackets: it is believed then. The end of a column's name may only be the one that
        mechid asks for.

    Raises
    ------
    InputFileError
        The other unit may be meant.
    """
    largest = float(np.max(np.abs(phase), initial=0.0))
    if unit == "deg":
        if not is_stated and _looks_like_radians(phase, magnitude):
            raise _doubt(
                place, f"all phases are within +-{largest:.6g}, and in degrees no resonance turns so little", "rad"
            )
        return np.radians(phase)
    if not is_stated and largest > LARGEST_RADIANS:
        raise _doubt(place, f"found {largest:.6g}, many turns in radians", "deg")
    return phase


def _doubt(place: str, why: str, other: str) -> InputFileError:
    own = "deg" if other == "rad" else "rad"
    return InputFileError(
        f"{place}: {why}; end the name in _phase [{other}] if that is the unit, in _phase [{own}] if it is right"
    )


def _looks_like_radians(phase: FloatArray, magnitude: FloatArray) -> bool:
    """Return whether a phase that is said to be in degrees can only be in radians.

    It is within half a turn of radians, and either turns at a resonance or lies at that half turn.
    """
    largest = float(np.max(np.abs(phase), initial=0.0))
    if largest > math.pi + HALF_TURN:
        return False
    turns = float(np.ptp(phase)) > TURN_TO_ASK and _has_resonance(magnitude)
    return turns or abs(largest - math.pi) < HALF_TURN


def _has_resonance(magnitude: FloatArray) -> bool:
    """Return whether a magnitude has a maximum from which it falls to a `PEAK`-th on either side."""
    before = np.minimum.accumulate(magnitude)
    after = np.minimum.accumulate(magnitude[::-1])[::-1]
    return bool(np.any(magnitude > PEAK * np.maximum(before, after)))
