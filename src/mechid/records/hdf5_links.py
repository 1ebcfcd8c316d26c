"""Safe traversal of links in an HDF5 file: no cycles, and no access to other files unless allowed.

A link may refer to another file, and a dataset may take its data from one, as external storage or as a virtual dataset.
Links may refer to a group that contains them, and many links may refer to one group: a file of a few kB can contain
2^32 paths.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any

from mechid.errors import RecordError

MAX_REVISITS = 2**10
"""Maximum number of visits of groups that have been visited before."""
MAX_LINK_LEVELS = 32
"""Maximum nesting of links and virtual datasets; no instrument nests them as deeply."""
SAME_FILE = "."
"""Name by which a virtual dataset refers to its own file."""
DANGLING_LINK = "a broken link within this file"
Within = frozenset[tuple[int, int]]
"""File numbers and addresses of the groups that contain an entry."""


class Links:
    """Access to those entries of an open HDF5 file that may be followed.

    Parameters
    ----------
    h5py : module
    label : str
        Name of the file in messages.
    external_files : collection of str
        Other files from which numbers may be taken, as named in this file.
    """

    def __init__(self, h5py: Any, label: str, external_files: Collection[str] = ()) -> None:
        self.h5py, self.label, self.external_files = h5py, label, external_files
        self._seen: set[tuple[int, int]] = set()
        self._again = 0
        self._used: dict[str, None] = {}

    def entries(self, group: Any, within: Within) -> Iterator[tuple[str, Any, str | None]]:
        """Yield name and object of each entry of a group, or None and the reason if it must not be followed."""
        for name in group:
            fault = self._link_fault(group, name, MAX_LINK_LEVELS)
            node = None if fault else group.get(name)
            fault = fault or self.find_fault(node, within)
            yield name, None if fault else node, fault

    def at(self, group: Any, path: str) -> Any:
        """Return the object at a path, or None if there is none.

        Raises
        ------
        RecordError
            The object must not be accessed.
        """
        fault = self._path_fault(group, path, MAX_LINK_LEVELS)
        if fault and fault != DANGLING_LINK:
            raise RecordError(f"{self.label}: {path}: {fault}")
        return None if fault else group.get(path)

    def resolve_reference(self, node: Any, reference: Any, within: Within) -> tuple[Any, str | None]:
        """Return the object of a reference, or None and the reason if it must not be followed."""
        found = node.file[reference]
        fault = self.find_fault(found, within)
        return (None, fault) if fault else (found, None)

    def enter(self, group: Any, within: Within) -> Within:
        """Return the containing groups for the entries of a group or cell, including itself.

        Raises
        ------
        RecordError
            Links lead to the same groups too often.
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
        """Warning about numbers of other files, which the digest of this file does not cover."""
        used = ", ".join(self._used)
        return (f"{self.label}: takes numbers from {used}, which its digest does not cover",) if used else ()

    def find_fault(self, node: Any, within: Within = frozenset()) -> str | None:
        """Return the reason why an object must not be accessed, or None."""
        if node is None:
            return DANGLING_LINK
        if self._place(node) in within:
            return "a link back to what it is in"
        return self._numbers_fault(node, MAX_LINK_LEVELS) if isinstance(node, self.h5py.Dataset) else None

    def _place(self, node: Any) -> tuple[int, int]:
        info = self.h5py.h5o.get_info(node.id)
        return info.fileno, info.addr

    def _numbers_fault(self, dataset: Any, levels: int) -> str | None:
        """Return the reason why the data of a dataset must not be read, or None."""
        others = [name for name, *_ in dataset.external or ()]
        sources = dataset.virtual_sources() if dataset.is_virtual else []
        others += [source.file_name for source in sources if source.file_name != SAME_FILE]
        if foreign := self._not_allowed(others):
            return f"its numbers are those of another file; {foreign}"
        here = (self._path_fault(dataset.file, s.dset_name, levels - 1) for s in sources if s.file_name == SAME_FILE)
        return next(filter(None, here), None)

    def _path_fault(self, group: Any, path: str, levels: int) -> str | None:
        """Return the reason why the object at a path must not be read, or None."""
        if levels < 0:
            return "links that form a cycle"
        here = group.file if path.startswith("/") else group
        for name in filter(None, path.split("/")):
            if not isinstance(here, self.h5py.Group):
                return DANGLING_LINK
            if fault := self._link_fault(here, name, levels - 1):
                return fault
            here = here[name]
        return self._numbers_fault(here, levels - 1) if isinstance(here, self.h5py.Dataset) else None

    def _link_fault(self, group: Any, name: str, levels: int) -> str | None:
        """Return the reason why a link must not be followed, or None."""
        # Only the link itself is examined: following it would already open another file.
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
        """Return the remedy for files that are not allowed, or an empty text if all are."""
        foreign = [name for name in dict.fromkeys(names) if name not in self.external_files]
        self._used |= dict.fromkeys(name for name in names if name in self.external_files)
        listed = ", ".join(f'"{name}"' for name in foreign)
        return f"if they are yours, allow it in the record: external_files = [{listed}]" if foreign else ""


def _text(name: bytes) -> str:
    return name.decode("utf-8", "surrogateescape")
