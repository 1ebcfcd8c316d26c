"""Public function that writes an index page of all results below a folder."""

from __future__ import annotations

import os
import shlex
import webbrowser
from collections.abc import Iterable
from datetime import datetime
from pathlib import Path
from urllib.parse import quote

from mechid.errors import UsageError
from mechid.indexes.document import index_page
from mechid.indexes.index import PAGE_NAME, Entry, Index
from mechid.indexes.kinds import BY_FILE, CAMPAIGNS, FITS, KINDS
from mechid.indexes.numbers import index_numbers
from mechid.indexes.result_reader import FoundResult, found_in
from mechid.indexes.staleness import Staleness
from mechid.indexes.walk import files_below
from mechid.reading.whole import is_file, is_folder
from mechid.writing import creating_folder, write_atomically

# An index.html of the user must not be overwritten, so pages are recognised by this mark.
MARK = b"mechid open</title>"
"""Mark of an index page."""
MARKED_WITHIN = 4096
"""Bytes at the beginning of a page in which the mark is searched."""


def open_results(folder: Path | str, *, browser: bool = False) -> Index:
    """Write ``index.html``, a page with links to all results below a folder.

    It has a card for each result, with the verdict, the first picture, and a notice if it is out of date. An earlier
    index is replaced; no other file is changed, and no server is needed.

    Parameters
    ----------
    folder : Path
        Folder to search. Links are followed; folders that begin with a dot are skipped.
    browser : bool
        Whether to open the page in a browser.

    Returns
    -------
    Index
        Its ``page`` is the path of the page.

    Raises
    ------
    UsageError
        There is no such folder, it contains no result, is not writable, or has an ``index.html`` not written by mechid.

    Examples
    --------
    >>> import mechid
    >>> [entry.headline for entry in mechid.open_results("bench").entries if entry.is_stale]  # doctest: +SKIP
    []
    """
    root = Path(folder)
    if not is_folder(root):
        raise UsageError(f"{root}: is no folder; give the one below which results lie")
    _refuse_foreign(root / PAGE_NAME)
    index = index_of(root)
    if not index.entries:
        raise UsageError(
            f"{root}: holds no campaign and no result of mechid; give a folder that was an --out, or above"
        )
    # The folder is not locked, since a running identification may hold it.
    with creating_folder(root):
        write_atomically(index.page, index_page(index_numbers(index)))
    if browser:
        webbrowser.open(index.page.resolve().as_uri())
    return index


def index_of(root: Path) -> Index:
    """Return the index of a folder without writing it."""
    unreadable: list[str] = []
    files = files_below(root, BY_FILE, unreadable)
    found = [one for file in files if (one := found_in(file, BY_FILE[file.name])) is not None]
    places = {kind.heading: place for place, kind in enumerate(KINDS)}
    found.sort(key=lambda one: (places[one.kind.heading], one.file))
    return Index(folder=root, entries=tuple(_entries(found, root)), unreadable=tuple(unreadable))


def _entries(results: Iterable[FoundResult], root: Path) -> Iterable[Entry]:
    results = tuple(results)
    staleness = Staleness(results)
    for found in results:
        below = found.folder.relative_to(root)
        page = found.folder / found.kind.page
        cautions = () if found.is_damaged else staleness.cautions(found)
        yield Entry(
            kind=found.kind.heading,
            name=_legible(below) if below.parts else root.resolve().name,
            headline=found.verdict.headline,
            tone=found.verdict.tone,
            lines=found.verdict.lines,
            cautions=cautions,
            written=_written_at(found.file),
            page=_page_address(page, root) if found.kind.page and is_file(page) else "",
            picture=_picture(found, root),
            command=_command(found, staleness, root),
            is_stale=any(line.startswith("stale") for line in cautions),
            is_damaged=found.is_damaged,
            synthetic=found.content.get("synthetic") is True,
        )


def _page_address(page: Path, root: Path) -> str:
    """Return the address of a page, with a parameter for its link back to the index."""
    depth = len(page.parent.relative_to(root).parts)
    return f"{_address(page, root)}?index={'../' * depth}{PAGE_NAME}"


def _address(file: Path, root: Path) -> str:
    """Return the address of a file relative to the index, with any character escaped."""
    return quote(os.fsencode(file.relative_to(root).as_posix()))


def _picture(found: FoundResult, root: Path) -> str:
    if not found.kind.picture:
        return ""
    try:
        names = sorted(p for p in (found.folder / found.kind.figure_folder).iterdir() if found.kind.picture in p.name)
    except OSError:
        return ""
    drawn = [path for path in names if path.suffix == ".svg"]
    return _address(drawn[0], root) if drawn else ""


def _command(found: FoundResult, staleness: Staleness, root: Path) -> str:
    """Return the command that opens a campaign or a fit in the explorer from the folder of the index."""
    if found.is_damaged or found.kind.heading not in (CAMPAIGNS, FITS):
        return ""
    campaign = found.file if found.kind.heading == CAMPAIGNS else staleness.campaign_of(found)
    if campaign is None:
        return ""
    words = ["mechid", "explore", _from(root, campaign)]
    # The explorer finds results beside the campaign file without the option.
    words += ["--fit", _from(root, found.folder)] if found.folder != campaign.parent else []
    return shlex.join(words)


def _from(root: Path, path: Path) -> str:
    below = (
        path.relative_to(root) if path.is_relative_to(root) else Path(os.path.relpath(path.resolve(), root.resolve()))
    )
    return _legible(below)


def _legible(path: Path) -> str:
    """Return a path as encodable text."""
    # File names on Linux are bytes and need not be valid UTF-8.
    return os.fsencode(path).decode("utf-8", errors="replace")


def _written_at(file: Path) -> str:
    try:
        return f"{datetime.fromtimestamp(file.stat().st_mtime):%Y-%m-%d %H:%M}"
    except (OSError, ValueError, OverflowError):
        return ""


def _refuse_foreign(page: Path) -> None:
    """Raise UsageError if there is an index.html that was not written by mechid."""
    try:
        with page.open("rb") as file:
            known = MARK in file.read(MARKED_WITHIN)
    except FileNotFoundError:
        return
    except OSError as error:
        raise UsageError(f"{page}: cannot be replaced ({error.strerror}); give the folder above") from error
    if not known:
        raise UsageError(f"{page}: is not an index by mechid, and is not replaced; rename it, or give the folder above")
