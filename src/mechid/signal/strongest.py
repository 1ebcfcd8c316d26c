"""Strongest spectral parts of a series: its lines, or third octaves if it has no dominant lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.signal.density import power_density, third_octaves
from mechid.signal.lines import prominence, spectral_lines
from mechid.signal.settings import SERIES


@dataclass(frozen=True, kw_only=True)
class StrongestParts:
    """Strongest spectral parts of a series, in descending order of power.

    Attributes
    ----------
    frequencies_hz : tuple of float
        Frequencies of lines, or centres of third octaves.
    in_lines : bool
        True if the parts are lines.
    """

    frequencies_hz: tuple[float, ...]
    in_lines: bool


def find_strongest(y: FloatArray, sample_rate: float) -> StrongestParts:
    """Return up to three of the strongest lines of a series, or third octaves if lines have less than half its power.

    Parameters
    ----------
    y : ndarray, shape (N,)
        In any unit, finite; its mean is ignored.
    sample_rate : float
        In Hz.

    Examples
    --------
    >>> t = np.arange(2000) / 1000.0
    >>> find_strongest(np.sin(2 * np.pi * 46.0 * t) + 2.0 * np.sin(2 * np.pi * 92.0 * t), 1000.0).frequencies_hz
    (92.0, 46.0)
    """
    power = float(np.var(y))
    if y.size < SERIES.shortest or not power > 0.0:
        return StrongestParts(frequencies_hz=(), in_lines=True)
    lines = [(0.5 * line.amplitude**2, line.frequency_hz) for line in spectral_lines(prominence(y, sample_rate))]
    if sum(part for part, _ in lines) >= SERIES.in_lines * power:
        return StrongestParts(frequencies_hz=_largest(lines), in_lines=True)
    bands = [(band.rms**2, band.centre_hz) for band in third_octaves(*power_density(y, sample_rate))]
    return StrongestParts(frequencies_hz=_largest(bands), in_lines=False)


def _largest(parts: list[tuple[float, float]]) -> tuple[float, ...]:
    """Return the frequencies of the strongest parts, which are pairs of power and frequency."""
    ordered = sorted(parts, reverse=True)
    return tuple(
        float(f"{hz:.4g}")
        for power, hz in ordered[: SERIES.most_named]
        if power >= SERIES.least_of_largest * ordered[0][0]
    )
