"""Scaling, offset and fill values in the attributes of an array.

Attributes of the CF conventions (``scale_factor``, ``add_offset``, ``_FillValue``, ``missing_value``, ``valid_range``,
``valid_min``, ``valid_max``, ``_Unsigned``) are applied, because their meaning is defined. For others, such as ``gain``
or ``sensitivity``, it is not known whether they multiply or divide, or whether the numbers are scaled already. A column
with such an attribute is read only if the campaign states its unit and gain.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechid.arrays import BoolArray, FloatArray

SCALE, OFFSET = "scale_factor", "add_offset"
FILLS = ("_FillValue", "missing_value")
RANGE, LEAST, MOST, UNSIGNED = "valid_range", "valid_min", "valid_max", "_Unsigned"
CF = (SCALE, OFFSET, *FILLS, RANGE, LEAST, MOST, UNSIGNED)
GAINS = (
    *("gain", "scale", "scaling", "scalefactor", "scalingfactor", "multiplier", "slope", "factor"),
    *("calibration", "calibrationfactor", "calibrationconstant", "calfactor", "conversionfactor"),
)
OFFSETS = ("offset", "addoffset", "intercept", "zerooffset")
POLYNOMIALS = ("coefficients", "polynomial", "calibrationcoefficients", "scalecoefficients", "scalingcoefficients")
INSTRUMENT = ("sensitivity", "resolution", "lsb", "bitresolution")
"""Attributes that describe the instrument if numbers have a unit, but a scaling of integers or unitless numbers."""
NUMBER = re.compile(r"\s*[x×]?\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(?:\s*(?![\d.:,-]).*)?", re.DOTALL)
"""Number, optionally followed by a unit, but not a date."""
NAMES = (*GAINS, *OFFSETS, *POLYNOMIALS, *INSTRUMENT)
SINCE = re.compile(r"\s+since\s+\d.*", re.DOTALL)
MAX_TEXT_LENGTH = 60
"""Maximum length of a text value in messages."""
UNLIMITED = (-np.inf, np.inf)

Attributes = Mapping[str, Any]
Limits = tuple[float, float]


@dataclass(frozen=True)
class Packing:
    """Conversion of stored numbers to measured values by the CF conventions: ``number * scale + offset``.

    Attributes
    ----------
    scale, offset : float
    fills : tuple of float
        Numbers that represent missing samples.
    numbers, values : tuple of float
        Valid ranges of stored numbers and of measured values.
    is_unsigned : bool
        Whether stored signed integers represent unsigned ones.
    """

    scale: float = 1.0
    offset: float = 0.0
    fills: tuple[float, ...] = ()
    numbers: Limits = UNLIMITED
    values: Limits = UNLIMITED
    is_unsigned: bool = False

    @property
    def is_scaled(self) -> bool:
        """Whether values differ from the stored numbers."""
        return self.scale != 1.0 or self.offset != 0.0

    def is_missing(self, stored: NDArray[Any]) -> BoolArray:
        """Return the mask of stored numbers, (N,), that represent missing samples."""
        numbers = self._reinterpret_sign(stored)
        found = ~_is_within(numbers, self.numbers) | ~_is_within(self._values(numbers), self.values)
        fills = np.array(self.fills)
        # Fill values are rounded like the stored numbers: -999.9 in 32 bits differs from -999.9 in 64 bits.
        if stored.dtype.kind == "f":
            with np.errstate(over="ignore"):
                fills = fills.astype(stored.dtype).astype(np.float64)
        return np.asarray(found | np.isin(numbers, fills))

    def unpack(self, stored: NDArray[Any]) -> FloatArray:
        """Return the measured values of stored numbers, (N,); NaN for missing samples."""
        values = self._values(self._reinterpret_sign(stored))
        values[self.is_missing(stored)] = np.nan
        return values

    def _values(self, numbers: FloatArray) -> FloatArray:
        # An absurd scale may overflow; values that are not finite are rejected later.
        with np.errstate(over="ignore", invalid="ignore"):
            return np.asarray(numbers * self.scale + self.offset)

    def _reinterpret_sign(self, stored: NDArray[Any]) -> FloatArray:
        if self.is_unsigned and stored.dtype.kind == "i":
            stored = stored.view(stored.dtype.str.replace("i", "u"))
        return stored.astype(np.float64)


def read_packing(attributes: Attributes, dtype: np.dtype[Any]) -> Packing | None:
    """Return the packing described by the CF attributes of an array, or None if there is none to apply."""
    if dtype.kind not in "fiu" or not any(name in attributes for name in CF):
        return None
    scale, offset = _single_factor(attributes.get(SCALE), 1.0), _single_factor(attributes.get(OFFSET), 0.0)
    is_unsigned = dtype.kind == "i" and str(_text(attributes.get(UNSIGNED))).lower() == "true"
    least, most = _limits(attributes)
    are_values = _are_of_values(attributes, dtype, (least, most), scale, offset)
    fills = [fill for name in FILLS for fill in _numbers(attributes.get(name))]
    # Fill values and limits of unsigned data are stored as signed numbers too; negative ones are shifted by 2^bits.
    modulus = 2.0 ** (8 * dtype.itemsize) if is_unsigned else 0.0
    if is_unsigned and not are_values:
        least, most = (limit + modulus if -modulus < limit < 0.0 else limit for limit in (least, most))
    return Packing(
        scale=scale,
        offset=offset,
        fills=tuple(fill + modulus if fill < 0.0 else fill for fill in fills),
        numbers=UNLIMITED if are_values else (least, most),
        values=(least, most) if are_values else UNLIMITED,
        is_unsigned=is_unsigned,
    )


def unapplied_scaling(attributes: Attributes, *, has_unit: bool, is_whole: bool, is_beside: bool = False) -> str | None:
    """Return the scaling attributes that are not applied, such as ``gain = 0.5``, or None.

    Parameters
    ----------
    attributes : Mapping
        Attributes by name, in any spelling; neutral values (a gain of 1, an offset of 0) are ignored.
    has_unit, is_whole : bool
        Whether the file states a unit of the numbers, and whether they are integers.
    is_beside : bool
        Whether the attributes belong to a neighbouring object; then even those of the conventions are not applied.
    """
    found = [
        f"{name} = {_format_value(value)}"
        for name, value in attributes.items()
        if (is_beside or not is_applied(name, value))
        and _is_scaling(name, value)
        and not (plain_name(name) in INSTRUMENT and has_unit and not is_whole)
    ]
    return ", ".join(found) or None


def is_scaling_name(name: str) -> bool:
    """Return whether an attribute of this name describes a scaling, fill values or a valid range."""
    return name in CF or plain_name(name) in NAMES


def is_applied(name: str, value: Any) -> bool:
    """Return whether `read_packing` applies an attribute: a factor must be one nonzero number, a range two numbers."""
    numbers = _numbers(value)
    if name in (SCALE, OFFSET):
        return len(numbers) == 1 and np.isfinite(numbers[0]) and not (name == SCALE and numbers[0] == 0.0)
    return name in CF and (name != RANGE or len(numbers) == 2)


def _is_scaling(name: str, value: Any) -> bool:
    """Return whether an attribute states a scaling that is not neutral."""
    plain, numbers = plain_name(name), _numbers(value)
    if not numbers:
        # A factor stated as text.
        return name in (SCALE, OFFSET)
    if plain in (*GAINS, *INSTRUMENT):
        return any(number != 1.0 for number in numbers)
    if plain in OFFSETS:
        return any(number != 0.0 for number in numbers)
    return plain in POLYNOMIALS or name in CF


def plain_unit(unit: str) -> str:
    """Return a unit without the reference date of the conventions.

    Examples
    --------
    >>> plain_unit("seconds since 2024-05-06 07:08:09"), plain_unit("mN*m")
    ('seconds', 'mN*m')
    """
    return SINCE.sub("", unit)


def plain_name(name: str) -> str:
    """Return a name in lower case without separators: `ScaleFactor` and `scale-factor` are equal."""
    return re.sub(r"[\s_.-]", "", name).lower()


def _limits(attributes: Attributes) -> Limits:
    """Return the valid range."""
    span = _numbers(attributes.get(RANGE))
    least, most = span if len(span) == 2 else UNLIMITED
    return max(_numbers(attributes.get(LEAST)), default=least), min(_numbers(attributes.get(MOST)), default=most)


def _are_of_values(attributes: Attributes, dtype: np.dtype[Any], limits: Limits, scale: float, offset: float) -> bool:
    """Return whether limits apply to the measured values rather than to the stored numbers.

    According to the NetCDF user's guide they do if their type differs from that of the stored integers. Some programs
    write all attributes as floats: limits beyond the values of all stored numbers apply to the stored numbers.
    """
    stated = [np.asarray(attributes[name]) for name in (RANGE, LEAST, MOST) if name in attributes]
    if dtype.kind not in "iu" or (scale, offset) == (1.0, 0.0) or not any(one.dtype.kind == "f" for one in stated):
        return False
    reached = sorted(float(end) * scale + offset for end in (np.iinfo(dtype).min, np.iinfo(dtype).max))
    return limits[0] > reached[0] or limits[1] < reached[1]


def _single_factor(value: Any, neutral: float) -> float:
    """Return a factor, or the neutral one if it is missing or not a single finite nonzero number."""
    numbers = _numbers(value)
    return numbers[0] if len(numbers) == 1 and np.isfinite(numbers[0]) and numbers[0] != 0.0 else neutral


def _numbers(value: Any) -> list[float]:
    """Return the numbers of an attribute: an array, a number, a text of numbers, or a text that begins with one."""
    text = _text(value)
    if text is None:
        array = np.asarray(value)
        return [float(number) for number in array.ravel()] if array.dtype.kind in "iuf" else []
    with suppress(ValueError):
        return [float(part) for part in re.split(r"[\s,;()\[\]]+", text) if part]
    matched = NUMBER.fullmatch(text)
    return [float(matched[1])] if matched else []


def _text(value: Any) -> str | None:
    """Return an attribute that is a single text, or None."""
    single = value.item() if isinstance(value, np.ndarray | np.generic) and value.size == 1 else value
    if isinstance(single, bytes):
        single = single.decode("utf-8", errors="replace")
    return single.strip("\0 ") if isinstance(single, str) else None


def _format_value(value: Any) -> str:
    """Return a value formatted for messages."""
    text = _text(value)
    return (
        f'"{" ".join(text.split())[:MAX_TEXT_LENGTH]}"'
        if text is not None
        else ", ".join(f"{number:.9g}" for number in _numbers(value)) or "..."
    )


def _is_within(values: FloatArray, limits: Limits) -> BoolArray:
    return np.asarray((values >= limits[0]) & (values <= limits[1]))
