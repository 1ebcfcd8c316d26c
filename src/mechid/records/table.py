"""Table that a reader of a file format returns: columns, and the place of every sample in the file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from mechid.arrays import FloatArray
from mechid.errors import RecordError
from mechid.records.scaling import Packing
from mechid.units import split_header

Fact = str | int | float
"""A serial number, a sensitivity, a start time: one entry of a file's metadata."""
Metadata = Mapping[str, Fact]
ALL = slice(None)


@dataclass(frozen=True)
class Clock:
    """Time of the first sample in s, and sample rate in Hz."""

    start_s: float
    rate_hz: float


@dataclass(frozen=True, kw_only=True)
class Column:
    """One series of numbers in a file, as the file's head describes it.

    Parameters
    ----------
    name : str
        As the file has it, perhaps with its unit; empty where it has none.
    path : str
        What it is called among all columns, as ``"group/channel"``; the name where left out.
    unit : str or None
        The unit that the file states apart from the name.
    unit_doubts : Mapping of str to str
        By quantity, words elsewhere in the file that may be the unit of a column that states none.
    samples : int or None
        Their number; None where only reading tells.
    clock : Clock or None
        The regular clock that the file gives this column.
    start_time : str or None
        Date and time of the first sample, ISO 8601.
    whole : bool
        Whether the numbers are stored as integers: perhaps raw counts.
    fault : str or None
        Why it cannot be a channel, as ``"complex numbers"``.
    packing : Packing or None
        How the stored numbers become measured values, where the file states it by the CF conventions.
    unapplied : str or None
        Scaling that the file states and that is not applied, as ``"gain = 0.5"``.
    metadata : Mapping
        What else the file says of it.
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
        """What it is called among all columns."""
        return self.path or self.name

    @property
    def bare_name(self) -> str:
        """The name without the unit that may stand in it."""
        return split_header(self.name)[0]

    @property
    def stated_unit(self) -> str | None:
        """The unit that the file states, apart from the name or in it."""
        return self.unit or split_header(self.name)[1]


class Table(Protocol):
    """An opened file: its head is known, its samples are read on demand."""

    @property
    def columns(self) -> tuple[Column, ...]:
        """The columns in the order of the file."""

    @property
    def is_ordered(self) -> bool:
        """Whether place means something: without other word the time is the first column, torque the second."""

    @property
    def is_sliced(self) -> bool:
        """Whether a part of the file can be read without the rest in memory."""

    @property
    def metadata(self) -> Metadata:
        """What the file says of itself."""

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is odd about the file and yet usable."""

    def read(self, wanted: Sequence[int], rows: slice = ALL) -> list[FloatArray]:
        """Return `rows` of the `wanted` columns, each of shape (N,) in the file's own unit, perhaps strided.

        Raises
        ------
        RecordError
            The file's rows are not what its head promises.
        """

    def blocks(self, wanted: Sequence[int], rows: slice = ALL) -> Iterator[list[FloatArray]]:
        """Yield the same block after block: the file is read once, and where `is_sliced` no more than a block is held.

        Raises
        ------
        RecordError
            As `read`.
        """

    def error(self, message: str, row: int | None = None) -> RecordError:
        """Make the error that says file, place of sample `row` (None: of the head) and `message`."""


def column_label(columns: Sequence[Column], index: int) -> str:
    """Return how messages call a column: by its name, or by its index from 0 where it has none."""
    return f'column "{columns[index].key}"' if columns[index].key else f"column {index}"
