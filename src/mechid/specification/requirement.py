"""Emission requirement: a mask over frequency for one direction and one kind of quantity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.records.components import AXES, FORCES, MOMENTS, TORQUE, Mounting
from mechid.signal.density import THIRD

AMPLITUDE, RMS, PSD, THIRD_OCTAVE, BAND_PEAK = "amplitude", "rms", "psd", "third_octave", "band_peak"
KINDS = (AMPLITUDE, RMS, PSD, THIRD_OCTAVE, BAND_PEAK)
IN_BANDS = (RMS, BAND_PEAK)
"""Kinds whose limits hold for the bands between neighbouring points of the mask."""
QUANTITY_OF = {
    **{f"f{axis}": force for axis, force in zip(AXES, FORCES, strict=True)},
    **{f"m{axis}": moment for axis, moment in zip(AXES, MOMENTS, strict=True)},
    TORQUE: TORQUE,
}
DIRECTIONS = tuple(QUANTITY_OF)
_DIRECTION_OF = {quantity: direction for direction, quantity in QUANTITY_OF.items()}


def direction_of(quantity: str, mounting: Mounting | None) -> str | None:
    """Return the direction that a channel measures; None where it is no force and no moment.

    Parameters
    ----------
    quantity : str
    mounting : Mounting or None
        With it the torque is the moment about the drive axis.
    """
    if quantity == TORQUE and mounting is not None:
        return _DIRECTION_OF[mounting.drive_moment]
    return _DIRECTION_OF.get(quantity)


def unit_of(direction: str, kind: str) -> str:
    """Return the SI unit of a kind of quantity in a direction.

    Examples
    --------
    >>> unit_of("fx", "amplitude"), unit_of("mz", "psd")
    ('N', 'N^2*m^2/Hz')
    """
    is_force = direction.startswith("f")
    if kind == PSD:
        return "N^2/Hz" if is_force else "N^2*m^2/Hz"
    return "N" if is_force else "N*m"


@dataclass(frozen=True, eq=False)
class Mask:
    """Limit over frequency.

    Parameters
    ----------
    frequencies_hz : ndarray, shape (P,)
        Ascending, above 0, P at least 2.
    limits : ndarray, shape (P,)
        Above 0, in the SI unit of the requirement.
    is_stepwise : bool
        Each limit holds from its point to the next one; otherwise straight lines on logarithmic axes join the points.
    """

    frequencies_hz: FloatArray
    limits: FloatArray
    is_stepwise: bool = False

    @property
    def range_hz(self) -> tuple[float, float]:
        """Its first and last frequency."""
        return float(self.frequencies_hz[0]), float(self.frequencies_hz[-1])

    def limit_at(self, frequency_hz: FloatArray) -> FloatArray:
        """Return the limit at frequencies, (n,); infinite outside the mask.

        Examples
        --------
        >>> mask = Mask(np.array([1.0, 100.0]), np.array([1.0, 0.01]))
        >>> mask.limit_at(np.array([10.0, 200.0])).round(12).tolist()
        [0.1, inf]
        """
        f = np.asarray(frequency_hz, dtype=np.float64)
        low, high = self.range_hz
        inside = (f >= low) & (f <= high)
        if self.is_stepwise:
            number = np.clip(np.searchsorted(self.frequencies_hz, f, side="right") - 1, 0, self.limits.size - 1)
            limit = self.limits[number]
        else:
            # 0 Hz has no logarithm; it is outside of every mask and replaced by infinity below.
            limit = np.exp(np.interp(np.log(np.maximum(f, low)), np.log(self.frequencies_hz), np.log(self.limits)))
        return np.asarray(np.where(inside, limit, np.inf), dtype=np.float64)

    @property
    def bands(self) -> list[tuple[float, float, float]]:
        """Bands between neighbouring points: lower and upper frequency in Hz, and the limit of the lower point."""
        f, limits = self.frequencies_hz.tolist(), self.limits.tolist()
        return list(zip(f[:-1], f[1:], limits[:-1], strict=True))


@dataclass(frozen=True, kw_only=True, eq=False)
class Requirement:
    """One ``[[requirement]]`` of the emission.

    Parameters
    ----------
    name : str
    direction : str
        One of `DIRECTIONS`.
    kind : str
        One of `KINDS`.
    mask : Mask
    rates : tuple of (float, float)
        Ranges of the step rate in full steps/s in which it holds; empty: at all rates.
    confidence : float
    margin_db : float
        By which the emission has to stay below the mask.
    exclude_mains : bool
        Whether lines of the electric grid are left out.
    resolution_hz : float
        Bin width of a power density.
    """

    name: str
    direction: str
    kind: str
    mask: Mask
    rates: tuple[tuple[float, float], ...] = ()
    confidence: float = 0.95
    margin_db: float = 0.0
    exclude_mains: bool = False
    resolution_hz: float = 1.0

    @property
    def unit(self) -> str:
        """SI unit of its limits."""
        return unit_of(self.direction, self.kind)

    @property
    def decibels(self) -> float:
        """Decibels of a factor ten: 20 of amplitudes, 10 of a power density."""
        return 10.0 if self.kind == PSD else 20.0

    @property
    def margin_factor(self) -> float:
        """Factor on the limits that `margin_db` makes, at most 1."""
        return float(10.0 ** (-self.margin_db / self.decibels))

    def holds_at(self, rate: float) -> bool:
        """Whether it holds at a step rate in full steps/s; NaN, a rate that is not known, is in no range."""
        return not self.rates or any(low <= abs(rate) <= high for low, high in self.rates)


def whole_bands(requirement: Requirement, band_hz: tuple[float, float]) -> list[tuple[float, float, float]]:
    """Return the bands of a requirement that lie inside a band as a whole: lower and upper frequency, and limit.

    A band that is cut off would be judged by a part of what it holds.
    """
    mask, (low, high) = requirement.mask, band_hz
    if requirement.kind in IN_BANDS:
        return [band for band in mask.bands if band[0] >= low and band[1] <= high]
    first, last = mask.range_hz
    # The tolerance keeps bands whose centre is an end of the mask, in spite of rounding.
    numbers = np.arange(np.ceil(10.0 * np.log10(first) - 1e-9), np.floor(10.0 * np.log10(last) + 1e-9) + 1)
    centres = 10.0 ** (numbers / 10.0)
    limits = mask.limit_at(np.clip(centres, first, last)).tolist()
    edges = [(c / THIRD**0.5, c * THIRD**0.5) for c in centres.tolist()]
    return [(a, b, limit) for (a, b), limit in zip(edges, limits, strict=True) if a >= low and b <= high]


def judged_parts(
    requirement: Requirement, band_hz: tuple[float, float]
) -> tuple[tuple[float, float] | None, tuple[tuple[float, float], ...]]:
    """Return the range of a requirement's mask that records with a usable band show, and the parts they do not, in Hz.

    Bands are judged as a whole or not at all; of the other kinds the part inside the band is judged.
    """
    if requirement.kind in (AMPLITUDE, PSD):
        first, last = requirement.mask.range_hz
        low, high = max(first, band_hz[0]), min(last, band_hz[1])
        if not low < high:
            return None, ((first, last),)
        return (low, high), tuple((a, b) for a, b in ((first, low), (high, last)) if a < b)
    judged = whole_bands(requirement, band_hz)
    left = [band[:2] for band in whole_bands(requirement, (0.0, np.inf)) if band not in judged]
    return (judged[0][0], judged[-1][1]) if judged else None, tuple(left)
