"""The line of sight over time under a torque that does not repeat."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.signal import cont2discrete, lfilter

from mechid.arrays import FloatArray
from mechid.structure.modes import Modes
from mechid.structure.structure import Structure


def line_of_sight_over_time(
    structure: Structure, torque: FloatArray, sample_rate_hz: float, highest_hz: float
) -> Iterator[FloatArray]:
    """Yield the rotation along each line of sight, (N, k) rad, of a structure at rest before the first sample.

    Modes are integrated in closed form, the torque linear between samples. Other models go through the Fourier
    transform, with as many zeros after the torque as it has samples, and nothing where they are not known.

    Parameters
    ----------
    structure : Structure
    torque : (N, k)
        N m; zero before the first sample.
    sample_rate_hz : float
    highest_hz : float
        Above it a model that is no modes is left out.
    """
    if isinstance(structure.model, Modes):
        yield from _by_modes(structure.model, torque, sample_rate_hz)
    else:
        yield from _by_transform(structure, torque, sample_rate_hz, highest_hz)


def _by_modes(modes: Modes, torque: FloatArray, sample_rate_hz: float) -> Iterator[FloatArray]:
    static = np.zeros(modes.line_of_sight.shape[0]) if modes.static is None else modes.static[1:]
    totals = [flexibility * torque for flexibility in static]
    for k, (w, zeta) in enumerate(zip(modes.omega, modes.damping, strict=True)):
        weights = modes.line_of_sight[:, k] * modes.interface[k]
        if not weights.any():
            continue
        oscillator = ([1.0], [1.0, 2.0 * zeta * w, w**2])
        numerator, denominator, _ = cont2discrete(oscillator, 1.0 / sample_rate_hz, method="foh")
        eta = lfilter(np.ravel(numerator), denominator, torque, axis=0)
        totals = [total + weight * eta for total, weight in zip(totals, weights, strict=True)]
    yield from totals


def _by_transform(
    structure: Structure, torque: FloatArray, sample_rate_hz: float, highest_hz: float
) -> Iterator[FloatArray]:
    n = 2 * len(torque)
    spectrum = np.fft.rfft(torque, n=n, axis=0)
    frequency = np.arange(len(spectrum)) * (sample_rate_hz / n)
    kept = frequency <= highest_hz
    for column in structure.to_line_of_sight(frequency[kept]).T:
        moved = np.zeros_like(spectrum)
        moved[kept] = np.nan_to_num(column)[:, None] * spectrum[kept]
        yield np.fft.irfft(moved, n=n, axis=0)[: len(torque)]
