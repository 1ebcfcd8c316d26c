"""Decimation with a zero-phase anti-alias filter.

The filter is a Kaiser-windowed sinc (Oppenheim and Schafer, Discrete-Time Signal Processing, 3rd ed., 7.5.3), whose
delay is compensated.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.signal.series import Series, blocks
from mechid.signal.stored_series import AT_ONCE, WritableSeries, allocate_series, is_long, pieces_of

ATTENUATION_DB = 100.0
"""Attenuation above `STOP`; the ripple of the pass band is the same 1e-5."""
MAX_MISSING_WEIGHT = 0.01
"""Maximum share of a filtered sample's absolute tap weights that may fall on missing samples."""
PASS, STOP = 0.95, 1.05
"""Band edges relative to the Nyquist frequency of the result: aliases remain above `PASS`."""


def anti_alias_filter(factor: int) -> FloatArray:
    """Return the taps of the low-pass filter for decimation by `factor`, shape (2 n + 1,); their sum is 1."""
    # Imported here because scipy.signal takes a second to load and is needed for decimation only.
    from scipy.signal import firwin, kaiserord

    taps, beta = kaiserord(ATTENUATION_DB, (STOP - PASS) / factor)
    return np.asarray(firwin(taps | 1, 1.0 / factor, window=("kaiser", beta)), dtype=np.float64)


def decimate(data: Series, factor: int) -> WritableSeries:
    """Return samples 0, factor, 2 factor, ... of the low-pass filtered `data`, without delay.

    Parameters
    ----------
    data : Series of N samples
        In any unit; N exceeds half the filter's length. The series is extended by point reflection at its ends, so
        constants and straight lines pass unchanged.
    factor : int
        Decimation factor, at least 2.

    Returns
    -------
    WritableSeries of ceil(N / factor) samples
    """

    def padded_data(start: int, stop: int) -> FloatArray:
        inside = data[max(start, 0) : min(stop, data.size)]
        beyond = (max(-start, 0), max(stop - data.size, 0))
        return np.pad(inside, beyond, mode="reflect", reflect_type="odd")

    return _filter_in_pieces(padded_data, data.size, anti_alias_filter(factor), factor)


def affected_samples(missing: IntArray, samples: int, factor: int) -> IntArray:
    """Return the indices of decimated samples that depend too strongly on missing input samples.

    Parameters
    ----------
    missing : (m,) of int
        Indices of the missing input samples, ascending.
    samples, factor : int
        Number of input samples, and decimation factor.

    Returns
    -------
    (s,) of int
        Indices of output samples with more than `MAX_MISSING_WEIGHT` of their weight on missing samples, ascending.
    """
    taps = np.abs(anti_alias_filter(factor))

    def missing_mask(start: int, stop: int) -> FloatArray:
        there = np.zeros(stop - start)
        there[missing[slice(*np.searchsorted(missing, (start, stop)))] - start] = 1.0
        return there

    weight = _filter_in_pieces(missing_mask, samples, taps, factor)
    found = [part.start + np.flatnonzero(weight[part] / taps.sum() > MAX_MISSING_WEIGHT) for part in pieces_of(weight)]
    return np.concatenate([np.zeros(0, dtype=np.int64), *found])


def _filter_in_pieces(
    padded: Callable[[int, int], FloatArray], samples: int, taps: FloatArray, factor: int
) -> WritableSeries:
    """Return the filtered and decimated samples, computed piece by piece.

    `padded` returns the input from a start to a stop index, which may lie beyond the ends of the series.
    """
    out, half = allocate_series(-(-samples // factor)), taps.size // 2
    for part in blocks(out.size, max(AT_ONCE // factor, 1)) if is_long(samples) else [slice(0, out.size)]:
        first, stop = part.start * factor, min(part.stop * factor, samples)
        out[part] = _filter_piece(padded(first - half, stop + half), taps, stop - first, factor)
    return out


def _filter_piece(padded: FloatArray, taps: FloatArray, samples: int, factor: int) -> FloatArray:
    """Return the filtered and decimated samples of a piece that is padded by half the filter's length at both ends."""
    from scipy.signal import upfirdn

    half = taps.size // 2
    # Leading zeros extend the delay to a multiple of the factor: upfirdn computes only every factor-th output.
    ahead = -2 * half % factor
    filtered = upfirdn(np.concatenate((np.zeros(ahead), taps)), padded, down=factor)
    first = (2 * half + ahead) // factor
    return np.asarray(filtered[first : first + -(-samples // factor)], dtype=np.float64)
