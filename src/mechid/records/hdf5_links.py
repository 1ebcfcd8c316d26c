"""Where the links of an HDF5 file lead: not to other files unless these are allowed, and not in circles.

A link may lead to another file, and a dataset may take its numbers from there: raw storage, or a virtual dataset. Links
may lead back to the group that they are in, and many to one group: a file of some kB may hold 2^32 paths.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any

from mechid.errors import RecordError

MAX_REVISITS = 2**10
"""So often groups may be reached that have been reached before."""
MAX_LINK_LEVELS = 32
"""Links to links, and virtual datasets of virtual ones: no instrument nests them so deep."""
SAME_FILE = "."
"""What a virtual dataset calls its own file."""
DANGLING_LINK = "a link to nothing in this file"
Within = frozenset[tuple[int, int]]
"""Files and addresses of the groups that an entry is in."""


class Links:
    """The entries of an open HDF5 file as far as they may be followed.

    Parameters
    ----------
    h5py : module
    label : str
        What messages call the file.
    external_files : collection of str
        Other files, as they are named in this one, that its numbers may come from.
    """

    def __init__(self, h5py: Any, label: str, external_files: Collection[str] = ()) -> None:
        self.h5py, self.label, self.external_files = h5py, label, external_files
        self._seen: set[tuple[int, int]] = set()
        self._again = 0
        self._used: dict[str, None] = {}

    def entries(self, group: Any, within: Within) -> Iterator[tuple[str, Any, str | None]]:
        """Yield name and object of each entry of a group; None, and why, where it is not to be followed."""
        for name in group:
            fault = self._link_fault(group, name, MAX_LINK_LEVELS)
            node = None if fault else group.get(name)
            fault = fault or self.find_fault(node, within)
            yield name, None if fault else node, fault

    def at(self, group: Any, path: str) -> Any:
        """Return the object at a path, None where there is none.

        Raises
        ------
        RecordError
            It is not to be looked at.
        """
        fault = self._path_fault(group, path, MAX_LINK_LEVELS)
        if fault and fault != DANGLING_LINK:
            raise RecordError(f"{self.label}: {path}: {fault}")
        return None if fault else group.get(path)

    def resolve_reference(self, node: Any, reference: Any, within: Within) -> tuple[Any, str | None]:
        """Return the object that a reference leads to; None, and why, where it is not to be followed."""
        found = node.file[reference]
        fault = self.find_fault(found, within)
        return (None, fault) if fault else (found, None)

    def enter(self, group: Any, within: Within) -> Within:
        """Return what the entries of a group, or of a cell, are within.

        Raises
        ------
        RecordError
            Links lead to the same groups again and again.
        """
        place = self._place(group)
        self._again += place in self._seen
        self._seen.add(place)
        if self._again > MAX_REVISITS:
            raise RecordError(
                f"{self.label}: links lead to the same groups more than {MAX_REVISITS} times; save its channels alone"
            )
        return within | {place}

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is odd: numbers of other files, which the digest of this one says nothing of."""
        used = ", ".join(self._used)
        return (f"{self.label}: takes numbers from {used}, which its digest does not cover",) if used else ()

    def find_fault(self, node: Any, within: Within = frozenset()) -> str | None:
        """Return why an object is not to be looked at, None where it may be."""
        if node is None:
            return DANGLING_LINK
        if self._place(node) in within:
            return "a link back to what it is in"
        return self._numbers_fault(node, MAX_LINK_LEVELS) if isinstance(node, self.h5py.Dataset) else None

    def _place(self, node: Any) -> tuple[int, int]:
        info = self.h5py.h5o.get_info(node.id)
        return info.fileno, info.addr

    def _numbers_fault(self, dataset: Any, levels: int) -> str | None:
        """Return why the numbers of a dataset are not to be read: they are another file's."""
        others = [name for name, *_ in dataset.external or ()]
        sources = dataset.virtual_sources() if dataset.is_virtual else []
        others += [source.file_name for source in sources if source.file_name != SAME_FILE]
        if foreign := self._not_allowed(others):
            return f"its numbers are those of another file; {foreign}"
        here = (self._path_fault(dataset.file, s.dset_name, levels - 1) for s in sources if s.file_name == SAME_FILE)
        return next(filter(None, here), None)

    def _path_fault(self, group: Any, path: str, levels: int) -> str | None:
        """Return why what a path leads to is not to be read."""
        if levels < 0:
            return "links to links without an end"
        here = group.file if path.startswith("/") else group
        for name in filter(None, path.split("/")):
            if not isinstance(here, self.h5py.Group):
                return DANGLING_LINK
            if fault := self._link_fault(here, name, levels - 1):
                return fault
            here = here[name]
        return self._numbers_fault(here, levels - 1) if isinstance(here, self.h5py.Dataset) else None

    def _link_fault(self, group: Any, name: str, levels: int) -> str | None:
        """Return why a link is not to be followed; it is not followed to tell."""
        links, link, h5l = group.id.links, name.encode("utf-8", "surrogateescape"), self.h5py.h5l
        if not links.exists(link):
            return DANGLING_LINK
        kind = links.get_info(link).type
        if kind == h5l.TYPE_HARD:
            return None
        if kind == h5l.TYPE_SOFT:
            return self._path_fault(group, _text(links.get_val(link)), levels)
        if kind == h5l.TYPE_EXTERNAL:
            foreign = self._not_allowed([_text(links.get_val(link)[0])])
            return f"a link to another file; {foreign}" if foreign else None
        return "a link of an unknown kind"

    def _not_allowed(self, names: Collection[str]) -> str:
        """Return what allows files that are not allowed yet, empty where there are none."""
        foreign = [name for name in dict.fromkeys(names) if name not in self.external_files]
        self._used |= dict.fromkeys(name for name in names if name in self.external_files)
        listed = ", ".join(f'"{name}"' for name in foreign)
        return f"if they are yours, allow it in the record: external_files = [{listed}]" if foreign else ""


def _text(name: bytes) -> str:
    return name.decode("utf-8", "surrogateescape")
