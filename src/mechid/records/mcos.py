"""Objects of MATLAB's classes in a .mat file: which there are, and the tree of what each holds.

MathWorks publishes no layout. That of the table of objects, ``FileWrapper__`` versions 2 to 4, is read as N.
Lakshmisha's mat-io describes it (docs/subsystem_data_format.md): names, classes, objects, and for each object which
property is in which cell. Cells are read by the reader of the file; here they are a tree of dicts (structs), lists
(cells), texts, arrays (`Item`) and further objects.
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
"""First word of a reference to objects; then dimensions, the objects' numbers, and that of their class."""
VERSIONS = (2, 3, 4)
FIRST = 2
"""The first cell that holds a value."""
IN_CELL = 1
"""Kind of a property whose value is in a cell."""
Words: TypeAlias = NDArray[np.uint32]
Tree: TypeAlias = Any
"""A dict of trees, a list of them, a text, an `Item`, an `Instance`, or None."""


@dataclass(frozen=True)
class Instance:
    """An object: its class and properties."""

    kind: str
    properties: Mapping[str, Tree]


@dataclass(frozen=True)
class Objects:
    """The table of objects.

    Attributes
    ----------
    classes : tuple of str
        Name of the class of each object, by the object's number.
    cells : tuple of mapping
        For each object its properties' names and cells, counted from the first that holds a value.
    """

    classes: tuple[str, ...]
    cells: tuple[Mapping[str, int], ...]


def referenced_objects(words: Words) -> tuple[int, ...]:
    """Return the numbers of the objects that an array of words refers to, none where it is no reference."""
    if words.size < 4 or words.dtype != np.uint32 or int(words.flat[0]) != REFERENCE:
        return ()
    flat = [int(word) for word in words.ravel()]
    count = int(np.prod(flat[2 : 2 + flat[1]]))
    return tuple(flat[2 + flat[1] : 2 + flat[1] + count])


def read_objects(blob: bytes) -> Objects:
    """Return the table of objects of the first cell of a ``FileWrapper__``.

    Raises
    ------
    ValueError, IndexError
        It is none, or of a version that nobody has described.
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
    """Return the cells of each object's properties: a count, three words for each, up to the next even place."""
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
    """The objects of a file, each made once; what its cells hold, the reader of the file tells by `tree`.

    Attributes
    ----------
    table : Objects or None
        None where it could not be read.
    cells : sequence
        As the file's reader has them.
    """

    def __init__(self, cells: Sequence[Any], blob: Callable[[Any], bytes]) -> None:
        self.cells = cells
        self.table: Objects | None = None
        self._made: dict[int, Instance | None] = {}
        with suppress(ValueError, IndexError):
            self.table = read_objects(blob(cells[0]))

    def instances(self, words: Words) -> list[Instance]:
        """Return the objects that an array of words refers to; none where it is no reference."""
        if self.table is None:
            return []
        return [
            found for number in referenced_objects(words) if (found := self._instance(self.table, number)) is not None
        ]

    def one_or_all(self, words: Words) -> Tree:
        """Return the object that is referred to, or the list of them; None where it is being made."""
        found = self.instances(words)
        return found[0] if len(found) == 1 else found or None

    def tree(self, node: Any) -> Tree:
        """Return what a cell, or a part of it, holds."""
        raise NotImplementedError

    def _instance(self, table: Objects, number: int) -> Instance | None:
        """Return an object; None while it is being made, as of one that holds itself."""
        if number not in self._made:
            self._made[number] = None
            listed = table.cells[number].items()
            held = {name: self.tree(self.cells[FIRST + cell]) for name, cell in listed}
            self._made[number] = Instance(table.classes[number], held)
        return self._made[number]
