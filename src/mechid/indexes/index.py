"""The index of all results below a folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mechid.errors import UsageError
from mechid.shown import Shown

PAGE_NAME = "index.html"


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One result.

    Attributes
    ----------
    kind : str
        Heading under which it stands.
    name : str
        Its folder, from that of the index.
    headline : str
        Its verdict.
    tone : str
        Of the verdict: good, caution, bad, or empty.
    lines : tuple of str
        What else is said of it.
    cautions : tuple of str
        Why it is out of date, or cannot be read.
    written : str
        Local time at which its file was written.
    page, picture : str
        Their addresses from the index; empty where there is none.
    command : str
        Opens it in the explorer; empty where that shows no such result.
    is_stale : bool
        Whether files that it was made of have changed since.
    is_damaged : bool
    synthetic : bool
        Whether its records were simulated.
    """

    kind: str
    name: str
    headline: str
    written: str
    tone: str = ""
    lines: tuple[str, ...] = ()
    cautions: tuple[str, ...] = ()
    page: str = ""
    picture: str = ""
    command: str = ""
    is_stale: bool = False
    is_damaged: bool = False
    synthetic: bool = False


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Index(Shown):
    """The index of all results below a folder.

    Attributes
    ----------
    folder : Path
    entries : tuple of Entry
        By kind, then by name.
    unreadable : tuple of str
        Folders that could not be listed.
    """

    folder: Path
    entries: tuple[Entry, ...]
    unreadable: tuple[str, ...] = ()

    @property
    def page(self) -> Path:
        """Where its page is."""
        return self.folder / PAGE_NAME

    def write(self, out: Path | str) -> list[Path]:
        """Write the page anew into the index's own folder, from which its links lead.

        Raises
        ------
        UsageError
            It is another folder, or it cannot be written to.
        """
        if Path(out).resolve() != self.folder.resolve():
            raise UsageError(f"{out}: an index leads from {self.folder}, and is written there")
        return super().write(out)
