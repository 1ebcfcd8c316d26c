"""Fewer samples without aliases: a linear-phase low-pass, its delay taken out, then every so manieth sample.

The filter is a Kaiser-windowed sinc, Oppenheim and Schafer, Discrete-Time Signal Processing, 3rd ed., 7.5.3.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.signal.series import Series, blocks
from mechid.signal.stored import AT_ONCE, Room, is_long, pieces_of, room_for

ATTENUATION_DB = 100.0
"""Of what is above `STOP`; the pass band is flat to the same 1e-5."""
SPOILT = 0.01
"""Share of a filtered sample's weight that may come from samples that were never measured."""
PASS, STOP = 0.95, 1.05
"""Edges of the filter, in the Nyquist frequency of the result: what folds back stays above `PASS`."""


def anti_alias_filter(factor: int) -> FloatArray:
    """Return the taps of the low-pass before a decimation by `factor`, shape (2 n + 1,), their sum 1."""
    from scipy.signal import firwin, kaiserord  # takes a second to load, which only those who decimate pay

    taps, beta = kaiserord(ATTENUATION_DB, (STOP - PASS) / factor)
    return np.asarray(firwin(taps | 1, 1.0 / factor, window=("kaiser", beta)), dtype=np.float64)


def decimate(data: Series, factor: int) -> Room:
    """Return samples 0, factor, 2 factor, ... of the low-passed `data`, each at its own instant.

    Parameters
    ----------
    data : Series of N samples
        In any unit, N above half the filter's length. Beyond its ends it is taken as its point
        reflection there, so a constant and a straight line pass unchanged.
    factor : int
        At least 2.

    Returns
    -------
    Room of ceil(N / factor) samples
    """

    def around(start: int, stop: int) -> FloatArray:
        inside = data[max(start, 0) : min(stop, data.size)]
        beyond = (max(-start, 0), max(stop - data.size, 0))
        return np.pad(inside, beyond, mode="reflect", reflect_type="odd")

    return _filtered(around, data.size, anti_alias_filter(factor), factor)


def spoilt_by(missing: IntArray, samples: int, factor: int) -> IntArray:
    """Return the samples behind `decimate` of which missing ones, ascending, have more than `SPOILT` of the weight."""
    taps = np.abs(anti_alias_filter(factor))

    def around(start: int, stop: int) -> FloatArray:
        there = np.zeros(stop - start)
        there[missing[slice(*np.searchsorted(missing, (start, stop)))] - start] = 1.0
        return there

    weight = _filtered(around, samples, taps, factor)
    found = [part.start + np.flatnonzero(weight[part] / taps.sum() > SPOILT) for part in pieces_of(weight)]
    return np.concatenate([np.zeros(0, dtype=np.int64), *found])


def _filtered(around: Callable[[int, int], FloatArray], samples: int, taps: FloatArray, factor: int) -> Room:
    """Return every so manieth of what the taps make of samples, piece by piece; `around` gives those of a stretch."""
    out, half = room_for(-(-samples // factor)), taps.size // 2
    for part in blocks(out.size, max(AT_ONCE // factor, 1)) if is_long(samples) else [slice(0, out.size)]:
        first, stop = part.start * factor, min(part.stop * factor, samples)
        out[part] = _every(around(first - half, stop + half), taps, stop - first, factor)
    return out


def _every(padded: FloatArray, taps: FloatArray, samples: int, factor: int) -> FloatArray:
    """Return every so manieth of what the taps make of data that half their number precedes and follows."""
    from scipy.signal import upfirdn

    half = taps.size // 2
    ahead = -2 * half % factor  # zeros in front move the delay onto a multiple of the factor
    filtered = upfirdn(np.concatenate((np.zeros(ahead), taps)), padded, down=factor)
    first = (2 * half + ahead) // factor
    return np.asarray(filtered[first : first + -(-samples // factor)], dtype=np.float64)
