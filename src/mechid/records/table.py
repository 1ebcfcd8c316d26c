"""Common interface of opened files: description of columns, and access to their samples."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from mechid.arrays import FloatArray
from mechid.errors import RecordError
from mechid.records.scaling import Packing
from mechid.units import split_header

Fact = str | int | float
"""Value of a metadata entry, such as a serial number, a sensitivity or a start time."""
Metadata = Mapping[str, Fact]
ALL = slice(None)


@dataclass(frozen=True)
class Clock:
    """Regular clock: time of the first sample in s, and sample rate in Hz."""

    start_s: float
    rate_hz: float


@dataclass(frozen=True, kw_only=True)
class Column:
    """Series of numbers in a file, as described by the file's header.

    Parameters
    ----------
    name : str
        Name in the file, possibly with a unit; empty if there is none.
    path : str
        Unique name among all columns, such as ``"group/channel"``; defaults to the name.
    unit : str or None
        Unit that the file states separately from the name.
    unit_doubts : Mapping of str to str
        Text elsewhere in the file that may state the unit of a column without one, by quantity.
    samples : int or None
        Number of samples; None if it is known only after reading.
    clock : Clock or None
        Regular clock that the file states for this column.
    start_time : str or None
        Date and time of the first sample, ISO 8601.
    whole : bool
        Whether the numbers are stored as integers, which may be raw counts.
    fault : str or None
        Reason why it cannot be a channel, such as ``"complex numbers"``.
    packing : Packing or None
        Conversion of stored numbers to measured values according to the CF conventions.
    unapplied : str or None
        Scaling that the file states but that is not applied, such as ``"gain = 0.5"``.
    metadata : Mapping
        Further metadata of the column.
    """

    name: str = ""
    path: str = ""
    unit: str | None = None
    unit_doubts: Mapping[str, str] = field(default_factory=dict)
    samples: int | None = None
    clock: Clock | None = None
    start_time: str | None = None
    whole: bool = False
    fault: str | None = None
    packing: Packing | None = None
    unapplied: str | None = None
    metadata: Metadata = field(default_factory=dict)

    @property
    def key(self) -> str:
        """Unique name among all columns."""
        return self.path or self.name

    @property
    def bare_name(self) -> str:
        """Name without a unit."""
        return split_header(self.name)[0]

    @property
    def stated_unit(self) -> str | None:
        """Unit that the file states, separately or in the name."""
        return self.unit or split_header(self.name)[1]


class Table(Protocol):
    """Opened file whose header is known and whose samples are read on demand."""

    @property
    def columns(self) -> tuple[Column, ...]:
        """Columns in the order of the file."""

    @property
    def is_ordered(self) -> bool:
        """Whether the order of columns matters: by default the time is the first column, the torque the second."""

    @property
    def is_sliced(self) -> bool:
        """Whether a part of the file can be read without having the rest in memory."""

    @property
    def metadata(self) -> Metadata:
        """Metadata of the file."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about a usable file."""

    def read(self, wanted: Sequence[int], rows: slice = ALL) -> list[FloatArray]:
        """Return `rows` of the `wanted` columns, each of shape (N,) in the file's unit, possibly strided.

        Raises
        ------
        RecordError
            The content of the file does not match its header.
        """

    def blocks(self, wanted: Sequence[int], rows: slice = ALL) -> Iterator[list[FloatArray]]:
        """Yield the same block by block; the file is read once, and if `is_sliced`, only one block is in memory.

        Raises
        ------
        RecordError
            As for `read`.
        """

    def error(self, message: str, row: int | None = None) -> RecordError:
        """Return an error with the file, the location of sample `row` (None for the header), and `message`."""


def column_label(columns: Sequence[Column], index: int) -> str:
    """Return the name of a column in messages: its key, or its index from 0 if it has none."""
    return f'column "{columns[index].key}"' if columns[index].key else f"column {index}"
