"""Index of all results below a folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mechid.display import DisplayedResult
from mechid.errors import UsageError

PAGE_NAME = "index.html"


@dataclass(frozen=True, kw_only=True)
class Entry:
    """Entry of one result.

    Attributes
    ----------
    kind : str
        Heading of its group.
    name : str
        Its folder, relative to that of the index.
    headline : str
        Its verdict.
    tone : str
        Tone of the verdict: good, caution, bad, or empty.
    lines : tuple of str
        Further lines of the verdict.
    cautions : tuple of str
        Reasons why it is out of date or cannot be read.
    written : str
        Local time of the last change of its file.
    page, picture : str
        Addresses relative to the index; empty if there is none.
    command : str
        Command that opens it in the explorer; empty for other kinds of result.
    is_stale : bool
        Whether its input files have changed since.
    is_damaged : bool
    synthetic : bool
        Whether the records were simulated.
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
class Index(DisplayedResult):
    """Index of all results below a folder.

    Attributes
    ----------
    folder : Path
    entries : tuple of Entry
        Entries by kind, then by name.
    unreadable : tuple of str
        Folders that could not be listed.
    """

    folder: Path
    entries: tuple[Entry, ...]
    unreadable: tuple[str, ...] = ()

    @property
    def page(self) -> Path:
        """Path of the page."""
        return self.folder / PAGE_NAME

    def write(self, out: Path | str, *, docx: bool = False) -> list[Path]:
        """Write the page again into the folder of the index, to which its links are relative.

        Raises
        ------
        UsageError
            `out` is another folder, the folder is not writable, or a Word document is wanted: an index has none.
        """
        if Path(out).resolve() != self.folder.resolve():
            raise UsageError(f"{out}: an index leads from {self.folder}, and is written there")
        return super().write(out, docx=docx)
