"""Transient response of the line of sight to a torque that is not periodic."""

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
    """Yield the rotation along each line of sight, (N, k) rad, of a structure that is initially at rest.

    Modes are integrated in closed form for a torque that is linear between samples. Other models are evaluated by the
    Fourier transform of the torque, padded by zeros to twice its length; unknown responses are taken as zero.

    Parameters
    ----------
    structure : Structure
    torque : (N, k)
        N m; zero before the first sample.
    sample_rate_hz : float
    highest_hz : float
        Upper frequency limit of models other than modes.
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
        # Modes of other axes need no integration.
        if not weights.any():
            continue
        oscillator = ([1.0], [1.0, 2.0 * zeta * w, w**2])
        # A first-order hold is exact for a torque that is linear between samples, at any sample rate.
        numerator, denominator, _ = cont2discrete(oscillator, 1.0 / sample_rate_hz, method="foh")
        eta = lfilter(np.ravel(numerator), denominator, torque, axis=0)
        totals = [total + weight * eta for total, weight in zip(totals, weights, strict=True)]
    yield from totals


def _by_transform(
    structure: Structure, torque: FloatArray, sample_rate_hz: float, highest_hz: float
) -> Iterator[FloatArray]:
    # Zero padding keeps the circular convolution of the transform from wrapping the end around to the beginning.
    n = 2 * len(torque)
    spectrum = np.fft.rfft(torque, n=n, axis=0)
    frequency = np.arange(len(spectrum)) * (sample_rate_hz / n)
    kept = frequency <= highest_hz
    for column in structure.to_line_of_sight(frequency[kept]).T:
        moved = np.zeros_like(spectrum)
        moved[kept] = np.nan_to_num(column)[:, None] * spectrum[kept]
        yield np.fft.irfft(moved, n=n, axis=0)[: len(torque)]
