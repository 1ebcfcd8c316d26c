"""``mechid open``: one page that leads to all results below a folder."""

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
from mechid.indexes.found import Found, found_in
from mechid.indexes.index import PAGE_NAME, Entry, Index
from mechid.indexes.kinds import BY_FILE, CAMPAIGNS, FITS, KINDS
from mechid.indexes.numbers import index_numbers
from mechid.indexes.staleness import Staleness
from mechid.indexes.walk import files_below
from mechid.reading.whole import is_file, is_folder
from mechid.writing import creating_folder, write_atomically

MARK = b"mechid open</title>"
"""By which a page shows that it is an index."""
MARKED_WITHIN = 4096
"""Bytes from a page's beginning."""


def open_results(folder: Path | str, *, browser: bool = False) -> Index:
    """Write one page, ``index.html``, that leads to all results below a folder.

    A card for each: its verdict, its first picture, whether it is out of date. An earlier index is replaced; no other
    file is touched, and no server is needed.

    Parameters
    ----------
    folder : Path
        Links are followed; folders that begin with a dot are passed over.
    browser : bool
        Whether the page is opened in a browser.

    Returns
    -------
    Index
        Its ``page`` is where the page lies.

    Raises
    ------
    UsageError
        It is no folder, holds no result, cannot be written to, or has an ``index.html`` that is not mechid's.

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
    with creating_folder(root):  # and not held: where an identification is at work its folder is
        write_atomically(index.page, index_page(index_numbers(index)))
    if browser:
        webbrowser.open(index.page.resolve().as_uri())
    return index


def index_of(root: Path) -> Index:
    """Return the index of a folder; nothing is written."""
    unreadable: list[str] = []
    files = files_below(root, BY_FILE, unreadable)
    found = [one for file in files if (one := found_in(file, BY_FILE[file.name])) is not None]
    places = {kind.heading: place for place, kind in enumerate(KINDS)}
    found.sort(key=lambda one: (places[one.kind.heading], one.file))
    return Index(folder=root, entries=tuple(_entries(found, root)), unreadable=tuple(unreadable))


def _entries(results: Iterable[Found], root: Path) -> Iterable[Entry]:
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
            written=_written(found.file),
            page=_page_address(page, root) if found.kind.page and is_file(page) else "",
            picture=_picture(found, root),
            command=_command(found, staleness, root),
            is_stale=any(line.startswith("stale") for line in cautions),
            is_damaged=found.is_damaged,
            synthetic=found.content.get("synthetic") is True,
        )


def _page_address(page: Path, root: Path) -> str:
    """Return the address of a page, with that by which the page leads back."""
    depth = len(page.parent.relative_to(root).parts)
    return f"{_address(page, root)}?index={'../' * depth}{PAGE_NAME}"


def _address(file: Path, root: Path) -> str:
    """Return the address of a file from the index, whatever letters its name has."""
    return quote(os.fsencode(file.relative_to(root).as_posix()))


def _picture(found: Found, root: Path) -> str:
    if not found.kind.picture:
        return ""
    try:
        names = sorted(p for p in (found.folder / found.kind.figure_folder).iterdir() if found.kind.picture in p.name)
    except OSError:
        return ""
    drawn = [path for path in names if path.suffix == ".svg"]
    return _address(drawn[0], root) if drawn else ""


def _command(found: Found, staleness: Staleness, root: Path) -> str:
    """Return what opens a campaign or a fit in the explorer, to be typed in the index's folder."""
    if found.is_damaged or found.kind.heading not in (CAMPAIGNS, FITS):
        return ""
    campaign = found.file if found.kind.heading == CAMPAIGNS else staleness.campaign_of(found)
    if campaign is None:
        return ""
    words = ["mechid", "explore", _from(root, campaign)]
    words += ["--fit", _from(root, found.folder)] if found.folder != campaign.parent else []
    return shlex.join(words)


def _from(root: Path, path: Path) -> str:
    below = (
        path.relative_to(root) if path.is_relative_to(root) else Path(os.path.relpath(path.resolve(), root.resolve()))
    )
    return _legible(below)


def _legible(path: Path) -> str:
    """Return a path as text that any file can hold."""
    return os.fsencode(path).decode("utf-8", errors="replace")


def _written(file: Path) -> str:
    try:
        return f"{datetime.fromtimestamp(file.stat().st_mtime):%Y-%m-%d %H:%M}"
    except (OSError, ValueError, OverflowError):
        return ""


def _refuse_foreign(page: Path) -> None:
    """Raise UsageError where an index.html is there that mechid has not written."""
    try:
        with page.open("rb") as file:
            known = MARK in file.read(MARKED_WITHIN)
    except FileNotFoundError:
        return
    except OSError as error:
        raise UsageError(f"{page}: cannot be replaced ({error.strerror}); give the folder above") from error
    if not known:
        raise UsageError(f"{page}: is not an index by mechid, and is not replaced; rename it, or give the folder above")
