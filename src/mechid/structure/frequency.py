"""Frequency columns of text files, in hertz or in another unit stated by the header."""

from __future__ import annotations

import math

from mechid.arrays import FloatArray
from mechid.errors import InputFileError
from mechid.units import conversion_factor

FREQUENCY, BARE, ANGULAR = "frequency_Hz", "frequency", "frequency_rad_s"


def as_hertz(name: str, unit: str | None, data: FloatArray, label: str) -> FloatArray | None:
    """Return a frequency column in Hz, (n,); None for any other column.

    Raises
    ------
    InputFileError
        The unit does not measure frequency, is missing, or contradicts the suffix of the column's name.

    Examples
    --------
    >>> import numpy as np
    >>> as_hertz("frequency", "rad/s", np.array([2.0 * np.pi]), "modes.csv")
    array([1.])
    >>> as_hertz("los_x", None, np.array([1.0]), "modes.csv")
    """
    if name not in (FREQUENCY, BARE, ANGULAR):
        return None
    place = f'{label}: column "{name}"'
    own = {FREQUENCY: "Hz", ANGULAR: "rad/s"}.get(name)
    if own is None and unit is None:
        raise InputFileError(f'{place}: states no unit; write "{FREQUENCY}", or "{BARE} [rad/s]"')
    if own is not None and unit is not None and conversion_factor(unit, own) != 1.0:
        raise InputFileError(f'{place}: has unit "{unit}"; write "{BARE} [{unit}]" if the unit is right')
    factor = _to_hertz(unit or own or "")
    if factor is None:
        raise InputFileError(f'{place}: unit "{unit}" is not valid here; expected Hz or rad/s')
    return factor * data


def _to_hertz(unit: str) -> float | None:
    # Angle is a dimension of its own: a unit converts to either Hz or rad/s, and pi enters here only.
    cycles, radians = conversion_factor(unit, "Hz"), conversion_factor(unit, "rad/s")
    return cycles if radians is None else radians / (2.0 * math.pi)
