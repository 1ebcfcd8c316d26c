"""Objects of MATLAB classes in a .mat file: the table of objects, and the content of each object as a tree.

The layout is not published by MathWorks. The table of objects, ``FileWrapper__`` versions 2 to 4, is read according to
N. Lakshmisha's mat-io (docs/subsystem_data_format.md): names, classes, objects, and the cell of each property of an
object. The reader of the file converts cells to trees of dicts (structs), lists (cells), texts, arrays (`Item`) and
further objects.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

REFERENCE = 0xDD000000
"""First word of a reference to objects, followed by dimensions, object numbers, and the class number."""
VERSIONS = (2, 3, 4)
FIRST = 2
"""Index of the first cell with a value."""
IN_CELL = 1
"""Kind of a property whose value is stored in a cell."""
Words: TypeAlias = NDArray[np.uint32]
Tree: TypeAlias = Any
"""Dict or list of trees, text, `Item`, `Instance`, or None."""


@dataclass(frozen=True)
class Instance:
    """Object with its class and properties."""

    kind: str
    properties: Mapping[str, Tree]


@dataclass(frozen=True)
class Objects:
    """Table of objects.

    Attributes
    ----------
    classes : tuple of str
        Class name of each object.
    cells : tuple of mapping
        Cell index of each property by name, for each object, counted from the first cell with a value.
    """

    classes: tuple[str, ...]
    cells: tuple[Mapping[str, int], ...]


def referenced_objects(words: Words) -> tuple[int, ...]:
    """Return the numbers of the objects that an array of words refers to; empty if it is not a reference."""
    if words.size < 4 or words.dtype != np.uint32 or int(words.flat[0]) != REFERENCE:
        return ()
    flat = [int(word) for word in words.ravel()]
    count = int(np.prod(flat[2 : 2 + flat[1]]))
    return tuple(flat[2 + flat[1] : 2 + flat[1] + count])


def read_objects(blob: bytes) -> Objects:
    """Return the table of objects in the first cell of a ``FileWrapper__``.

    Raises
    ------
    ValueError, IndexError
        The content is not a table of objects, or its version is unknown.
    """
    words = np.frombuffer(blob[: len(blob) // 4 * 4], dtype="<i4")
    if words.size < 10 or words[0] not in VERSIONS:
        raise ValueError("a table of objects of another version")
    offsets = [int(offset) for offset in words[2:10]]
    names = ["", *(name.decode() for name in blob[40 : offsets[0]].split(b"\0"))]
    regions = [words[a // 4 : b // 4].tolist() for a, b in pairwise(offsets[:5])]
    classes = [".".join(filter(None, (names[a], names[b]))) for a, b, *_ in _blocks(regions[0], 4)]
    saved, plain = (_properties(region, names) for region in (regions[1], regions[3]))
    objects = [*_blocks(regions[2], 6)]
    return Objects(
        classes=tuple(classes[kind] for kind, *_ in objects),
        cells=tuple(saved[s] if s else plain[n] for _, _, _, s, n, _ in objects),
    )


def _blocks(words: Sequence[int], size: int) -> Iterator[Sequence[int]]:
    return (words[at : at + size] for at in range(0, len(words) - size + 1, size))


def _properties(words: Sequence[int], names: Sequence[str]) -> list[dict[str, int]]:
    """Return the cells of each object's properties by name."""
    # Layout of an entry: the number of properties, three words for each, and padding to an even position.
    found, at = [], 0
    while at < len(words):
        if words[at] < 0:
            raise ValueError("a count of properties below 0")
        end = at + 1 + 3 * words[at]
        listed = _blocks(words[at + 1 : end], 3)
        found.append({names[name]: cell for name, kind, cell in listed if kind == IN_CELL})
        at = end + end % 2
    return found


class Heap:
    """Objects of a file, each created once; subclasses implement `tree` for the cells of a file format.

    Attributes
    ----------
    table : Objects or None
        None if the table of objects could not be read.
    cells : sequence
        Cells in the representation of the file's reader.
    """

    def __init__(self, cells: Sequence[Any], blob: Callable[[Any], bytes]) -> None:
        self.cells = cells
        self.table: Objects | None = None
        self._made: dict[int, Instance | None] = {}
        with suppress(ValueError, IndexError):
            self.table = read_objects(blob(cells[0]))

    def instances(self, words: Words) -> list[Instance]:
        """Return the objects that an array of words refers to; empty if it is not a reference."""
        if self.table is None:
            return []
        return [
            found for number in referenced_objects(words) if (found := self._instance(self.table, number)) is not None
        ]

    def one_or_all(self, words: Words) -> Tree:
        """Return the referenced object, or the list of several; None if it is still being created."""
        found = self.instances(words)
        return found[0] if len(found) == 1 else found or None

    def tree(self, node: Any) -> Tree:
        """Return the content of a cell or of a part of it."""
        raise NotImplementedError

    def _instance(self, table: Objects, number: int) -> Instance | None:
        """Return an object, or None while it is being created."""
        # The entry is reserved before its content is read: an object that contains itself would recurse endlessly.
        if number not in self._made:
            self._made[number] = None
            listed = table.cells[number].items()
            held = {name: self.tree(self.cells[FIRST + cell]) for name, cell in listed}
            self._made[number] = Instance(table.classes[number], held)
        return self._made[number]
