"""What a reader of a file format gives: columns, and the place of every sample in the file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mechid.errors import RecordError

FloatArray = NDArray[np.float64]


class Table(Protocol):
    """An opened file: its head is known, its samples are read on demand."""

    @property
    def columns(self) -> tuple[str, ...]:
        """Headers from left to right, units included; empty texts where the file has none."""

    def read(self, wanted: Sequence[int]) -> list[FloatArray]:
        """Return the `wanted` columns, each of shape (N,) in the file's own unit, perhaps strided.

        Raises
        ------
        RecordError
            The file's rows are not what its head promises.
        """

    def error(self, message: str, row: int | None = None) -> RecordError:
        """Make the error that says file, place of sample `row` (None: of the head) and `message`."""


def column_label(columns: Sequence[str], index: int) -> str:
    """Return how messages call a column: by its header, or by its index from 0 where it has none."""
    return f'column "{columns[index]}"' if columns[index] else f"column {index}"
