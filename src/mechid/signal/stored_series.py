"""Series too long for memory, stored in a temporary file and accessed piece by piece.

If the system allows, the file has no name, so that nothing remains of it however the process ends. It is in mechid's
cache folder (``MECHID_CACHE`` overrides it), because the system's folder for temporary files may be in memory.
"""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable
from threading import Lock
from typing import Protocol
from weakref import finalize

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.errors import UsageError
from mechid.signal.series import Series, Stretch, blocks
from mechid.writing import cache_folder

MAX_IN_MEMORY = 2**21
"""Maximum number of samples of a series held as an array in memory: 16 MiB."""
AT_ONCE = 2**18
"""Usual number of samples of a longer series that are in memory at once."""
WORD = 8
"""Bytes per sample."""


class WritableSeries(Series, Protocol):
    """Series that is written by slices: an array, or a temporary file."""

    def __setitem__(self, part: slice, values: FloatArray | float, /) -> None:
        """Write the samples of a slice."""


class StoredSeries:
    """Series in a temporary file, which several threads may read at once.

    Parameters
    ----------
    size : int
        Number of samples, which are 0 until they are written.

    Raises
    ------
    UsageError
        The cache folder cannot be written to, or has not enough free space.
    """

    def __init__(self, size: int) -> None:
        self.size = size
        try:
            if free_bytes() < WORD * size:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            self._file = tempfile.TemporaryFile(dir=cache_folder(), prefix="samples_", buffering=0)  # noqa: SIM115
            finalize(self, self._file.close)
            self._file.truncate(WORD * size)
        except OSError as error:
            raise _refusal(error) from error
        self._alone = Lock()

    def __getitem__(self, part: slice, /) -> FloatArray:
        """Return a copy of the samples of a slice with a positive step."""
        start, stop, step = part.indices(self.size)
        values = np.empty(max(stop - start, 0))
        self._read(values, WORD * start)
        return values if step == 1 else values[::step].copy()

    def __setitem__(self, part: slice, values: FloatArray | float, /) -> None:
        """Write the samples of a slice with step 1."""
        start, stop, _ = part.indices(self.size)
        own = np.ascontiguousarray(np.broadcast_to(values, stop - start), dtype=np.float64)
        try:
            with self._alone:
                self._file.seek(WORD * start)
                left = _bytes_of(own)
                while left:
                    left = left[self._file.write(left) :]
        except OSError as error:
            raise _refusal(error) from error

    def __reduce__(self) -> tuple[Callable[[int, list[bytes]], StoredSeries], tuple[int, list[bytes]]]:
        """Pickle the samples themselves, since another process cannot open the file."""
        return _restore, (self.size, [self[part].tobytes() for part in blocks(self.size, AT_ONCE)])

    def _read(self, values: FloatArray, place: int) -> None:
        """Fill an array from a position of the file in bytes."""
        left = _bytes_of(values)
        while left:
            # preadv does not move the file's position, which threads and forked processes share.
            if hasattr(os, "preadv"):
                done = os.preadv(self._file.fileno(), [left], place)
            else:
                with self._alone:
                    self._file.seek(place)
                    done = self._file.readinto(left)
            if not done:
                raise _refusal(OSError(f"the file ends at byte {place}"))
            left, place = left[done:], place + done


class StoredStretch(Stretch):
    """Writable view on a stretch of a stored series."""

    series: WritableSeries

    def __setitem__(self, part: slice, values: FloatArray | float, /) -> None:
        """Write the samples of a slice with step 1."""
        start, stop, _ = part.indices(self.size)
        self.series[self.first + start : self.first + stop] = values


def free_bytes() -> int:
    """Return the free space in bytes of the cache folder, which is created if necessary."""
    cache_folder().mkdir(parents=True, exist_ok=True)
    return shutil.disk_usage(cache_folder()).free


def allocate_series(samples: int) -> WritableSeries:
    """Return a series to be written: an array, or a temporary file for more than `MAX_IN_MEMORY` samples."""
    return StoredSeries(samples) if is_long(samples) else np.empty(samples)


def as_writable(values: FloatArray) -> WritableSeries:
    """Return samples, (n,), as a writable series: the array itself, or a temporary file if it is long."""
    if not is_long(values.size):
        return values
    room = allocate_series(values.size)
    for part in blocks(values.size, AT_ONCE):
        room[part] = values[part]
    return room


def is_long(samples: int) -> bool:
    """Return whether a number of samples exceeds `MAX_IN_MEMORY`."""
    return samples > MAX_IN_MEMORY


def pieces_of(series: Series) -> Iterable[slice]:
    """Return the slices in which a series is processed: a single one, or blocks of a long series.

    Sums over a series in memory are thereby bitwise equal to those of NumPy's functions.
    """
    return blocks(series.size, AT_ONCE) if is_long(series.size) else [slice(0, series.size)]


class SampleBuffer:
    """Buffer of samples that arrive piece by piece, moved to a temporary file beyond `MAX_IN_MEMORY` samples."""

    def __init__(self) -> None:
        self._parts: list[FloatArray] = []
        self._held = 0
        self._stored: StoredSeries | None = None

    def append(self, part: FloatArray) -> None:
        """Append samples, (n,)."""
        self._parts.append(np.array(part, dtype=np.float64))
        self._held += part.size
        if self._held > AT_ONCE if self._stored else is_long(self._held):
            self._spill()

    def series(self) -> WritableSeries:
        """Return all samples."""
        if self._stored is None:
            return self._parts[0] if len(self._parts) == 1 else np.concatenate([np.empty(0), *self._parts])
        self._spill()
        return self._stored

    def _spill(self) -> None:
        if self._stored is None:
            self._stored = StoredSeries(0)
        stored, parts, self._parts, self._held = self._stored, self._parts, [], 0
        for part in parts:
            start, stored.size = stored.size, stored.size + part.size
            stored[start : stored.size] = part


def map_samples(series: Series, change: Callable[[FloatArray, slice], FloatArray]) -> WritableSeries:
    """Apply a function of samples and their slice to a series, piece by piece, and return the resulting series."""
    out = allocate_series(series.size)
    for part in pieces_of(out):
        out[part] = change(series[part], part)
    return out


def change_in_place(room: WritableSeries, change: Callable[[FloatArray, slice], FloatArray]) -> None:
    """Apply a function of samples and their slice to a series in place, piece by piece."""
    for part in pieces_of(room):
        room[part] = change(room[part], part)


def stretch_in_place(room: WritableSeries, first: int, stop: int) -> WritableSeries:
    """Return a writable view on the samples from `first` to before `stop`."""
    if isinstance(room, np.ndarray):
        return np.ascontiguousarray(room[first:stop])
    return StoredStretch(room, *slice(first, stop).indices(room.size)[:2])


def samples_at(series: Series, numbers: IntArray) -> FloatArray:
    """Return the samples at indices, (m,) ascending."""
    found = [series[part][_positions_within(numbers, part)] for part in pieces_of(series)]
    return np.concatenate(found) if found else np.empty(0)


def write_at(room: WritableSeries, numbers: IntArray, to_write: FloatArray | float) -> None:
    """Write samples at indices, (m,) ascending."""
    values = np.broadcast_to(to_write, numbers.shape)
    for part in pieces_of(room):
        first, stop = np.searchsorted(numbers, (part.start, part.stop))
        if stop > first:
            piece = room[part]
            piece[numbers[first:stop] - part.start] = values[first:stop]
            room[part] = piece


def _positions_within(numbers: IntArray, part: slice) -> IntArray:
    first, stop = np.searchsorted(numbers, (part.start, part.stop))
    return np.asarray(numbers[first:stop] - part.start, dtype=np.int64)


def _bytes_of(values: FloatArray) -> memoryview:
    """Return a view on the bytes of an array."""
    return memoryview(values.data).cast("B") if values.size else memoryview(b"")


def _restore(size: int, parts: list[bytes]) -> StoredSeries:
    stored, start = StoredSeries(size), 0
    for part in parts:
        values = np.frombuffer(part)
        stored[start : start + values.size] = values
        start += values.size
    return stored


def _refusal(error: OSError) -> UsageError:
    return UsageError(
        f"{cache_folder()}: cannot store the samples of a long record temporarily ({error.strerror or error}); "
        "free some space, set MECHID_CACHE to another folder, or use a part of the record with window_s"
    )
