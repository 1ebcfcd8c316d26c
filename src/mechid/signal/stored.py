"""Series that are too long for memory: kept in a temporary file, written and read piece by piece.

The file has no name where the system allows that, so that nothing of it stays however a process ends. It lies in
mechid's cache folder (``MECHID_CACHE`` overrides it), since a system's folder for temporary files may itself be memory.
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

IN_MEMORY = 2**21
"""Samples of a series up to which it is an array in memory: 16 MiB."""
AT_ONCE = 2**18
"""Samples of a longer one that are in memory together, as a rule."""
WORD = 8
"""Bytes a sample."""


class Room(Series, Protocol):
    """Series of a known number of samples, to be written by slices: an array, or a temporary file."""

    def __setitem__(self, part: slice, values: FloatArray | float, /) -> None:
        """Write the samples of a slice."""


class Stored:
    """Samples in a temporary file; several threads may read it at once.

    Parameters
    ----------
    size : int
        Number of samples; 0 until they are written.

    Raises
    ------
    UsageError
        The cache folder cannot be written to, or has no room for them.
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
        """Return the samples of a slice with a positive step, an array of their own."""
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

    def __reduce__(self) -> tuple[Callable[[int, list[bytes]], Stored], tuple[int, list[bytes]]]:
        """Go to another process as the samples themselves."""
        return _restored, (self.size, [self[part].tobytes() for part in blocks(self.size, AT_ONCE)])

    def _read(self, values: FloatArray, place: int) -> None:
        """Fill an array from a place of the file in bytes."""
        left = _bytes_of(values)
        while left:
            if hasattr(os, "preadv"):  # without the file's own place, which threads and forked processes share
                done = os.preadv(self._file.fileno(), [left], place)
            else:
                with self._alone:
                    self._file.seek(place)
                    done = self._file.readinto(left)
            if not done:
                raise _refusal(OSError(f"the file ends at byte {place}"))
            left, place = left[done:], place + done


class StoredStretch(Stretch):
    """A stretch of samples in a temporary file, that is written too."""

    series: Room

    def __setitem__(self, part: slice, values: FloatArray | float, /) -> None:
        """Write the samples of a slice with step 1."""
        start, stop, _ = part.indices(self.size)
        self.series[self.first + start : self.first + stop] = values


def free_bytes() -> int:
    """Return how many bytes are free where long series are kept; the folder is made."""
    cache_folder().mkdir(parents=True, exist_ok=True)
    return shutil.disk_usage(cache_folder()).free


def room_for(samples: int) -> Room:
    """Return room for so many samples: an array, or a temporary file where they are more than `IN_MEMORY`."""
    return Stored(samples) if is_long(samples) else np.empty(samples)


def room_of(values: FloatArray) -> Room:
    """Return samples, (n,), as room: themselves, or a temporary file where they are many."""
    if not is_long(values.size):
        return values
    room = room_for(values.size)
    for part in blocks(values.size, AT_ONCE):
        room[part] = values[part]
    return room


def is_long(samples: int) -> bool:
    """Return whether so many samples are too many to be in memory at once."""
    return samples > IN_MEMORY


def pieces_of(series: Series) -> Iterable[slice]:
    """Return the slices in which a series is looked at: all of it at once where that is not long, else blocks.

    So sums over it are to the last bit those of NumPy's own functions where they are over an array.
    """
    return blocks(series.size, AT_ONCE) if is_long(series.size) else [slice(0, series.size)]


class Gathered:
    """Samples that come piece by piece: in memory until there are more than `IN_MEMORY`, then in a temporary file."""

    def __init__(self) -> None:
        self._parts: list[FloatArray] = []
        self._held = 0
        self._stored: Stored | None = None

    def append(self, part: FloatArray) -> None:
        """Add samples, (n,), at the end."""
        self._parts.append(np.array(part, dtype=np.float64))
        self._held += part.size
        if self._held > AT_ONCE if self._stored else is_long(self._held):
            self._spill()

    def series(self) -> Room:
        """Return all samples."""
        if self._stored is None:
            return self._parts[0] if len(self._parts) == 1 else np.concatenate([np.empty(0), *self._parts])
        self._spill()
        return self._stored

    def _spill(self) -> None:
        if self._stored is None:
            self._stored = Stored(0)
        stored, parts, self._parts, self._held = self._stored, self._parts, [], 0
        for part in parts:
            start, stored.size = stored.size, stored.size + part.size
            stored[start : stored.size] = part


def changed(series: Series, change: Callable[[FloatArray, slice], FloatArray]) -> Room:
    """Return what a change of its samples makes of a series, piece by piece; the slice says which they are."""
    out = room_for(series.size)
    for part in pieces_of(out):
        out[part] = change(series[part], part)
    return out


def change_in_place(room: Room, change: Callable[[FloatArray, slice], FloatArray]) -> None:
    """Change the samples of a series, piece by piece; the slice says which they are."""
    for part in pieces_of(room):
        room[part] = change(room[part], part)


def stretch_in_place(room: Room, first: int, stop: int) -> Room:
    """Return the samples from `first` to before `stop`, to be changed as the room itself: they are the same."""
    if isinstance(room, np.ndarray):
        return np.ascontiguousarray(room[first:stop])
    return StoredStretch(room, *slice(first, stop).indices(room.size)[:2])


def samples_at(series: Series, numbers: IntArray) -> FloatArray:
    """Return the samples of some numbers, (m,) ascending."""
    found = [series[part][_inside(numbers, part)] for part in pieces_of(series)]
    return np.concatenate(found) if found else np.empty(0)


def write_at(room: Room, numbers: IntArray, to_write: FloatArray | float) -> None:
    """Write the samples of some numbers, (m,) ascending."""
    values = np.broadcast_to(to_write, numbers.shape)
    for part in pieces_of(room):
        first, stop = np.searchsorted(numbers, (part.start, part.stop))
        if stop > first:
            piece = room[part]
            piece[numbers[first:stop] - part.start] = values[first:stop]
            room[part] = piece


def _inside(numbers: IntArray, part: slice) -> IntArray:
    first, stop = np.searchsorted(numbers, (part.start, part.stop))
    return np.asarray(numbers[first:stop] - part.start, dtype=np.int64)


def _bytes_of(values: FloatArray) -> memoryview:
    """Return the bytes of an array, to be read or written."""
    return memoryview(values.data).cast("B") if values.size else memoryview(b"")


def _restored(size: int, parts: list[bytes]) -> Stored:
    stored, start = Stored(size), 0
    for part in parts:
        values = np.frombuffer(part)
        stored[start : start + values.size] = values
        start += values.size
    return stored


def _refusal(error: OSError) -> UsageError:
    return UsageError(
        f"{cache_folder()}: the samples of a long record cannot be kept there while they are read "
        f"({error.strerror or error}); make room, name another folder in MECHID_CACHE, "
        "or use a part of the record with window_s"
    )
