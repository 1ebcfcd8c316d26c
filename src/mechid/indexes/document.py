"""Document of an index: a card for each result, grouped by kind."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import groupby
from pathlib import Path
from typing import Any

from mechid.indexes.index import PAGE_NAME, Index
from mechid.indexes.numbers import index_numbers
from mechid.indexes.verdicts import count_words
from mechid.ink.document import (
    BAD,
    CAUTION,
    GOOD,
    IN_DOCUMENTS,
    ON_TERMINAL,
    Card,
    Cards,
    Document,
    Lines,
    Section,
    Verdict,
    Words,
)
from mechid.ink.on_page import document_page
from mechid.ink.page_rules import CARDS
from mechid.ink.presenter import Presenter

COMMANDS = "The commands are for a terminal in this folder: they open a campaign or a fit in the explorer."


def index_document(data: Mapping[str, Any]) -> Document:
    """Make the document from the result of `index_numbers`."""
    # The entries are sorted by kind, as groupby requires.
    kinds = [(kind, list(group)) for kind, group in groupby(data["entries"], key=lambda one: str(one["kind"]))]
    unreadable = [f"{folder}: cannot be listed" for folder in data["unreadable"]]
    return Document(
        title=f"Results in {Path(data['folder']).resolve().name}",
        command="mechid open",
        shows_files=True,
        parts=(
            _verdict(data["entries"]),
            Lines(unreadable, "caution", "Not looked into", "yellow"),
            *(
                Section(kind, (Cards([_card(one) for one in group]),), kind.lower(), f"{kind} ({len(group)})")
                for kind, group in kinds
            ),
            Words(COMMANDS, "soft", where=IN_DOCUMENTS),
            Words(data["page"], where=ON_TERMINAL),
        ),
    )


def _verdict(entries: list[Mapping[str, Any]]) -> Verdict:
    stale, damaged = (sum(one[key] for one in entries) for key in ("is_stale", "is_damaged"))
    words = [count_words(len(entries), "result"), *([f"{stale} out of date"] if stale else [])]
    words += [f"{damaged} damaged"] if damaged else []
    return Verdict(", ".join(words), tone=BAD if damaged else CAUTION if stale else GOOD)


def _card(entry: Mapping[str, Any]) -> Card:
    synthetic = "synthetic, " if entry["synthetic"] else ""
    return Card(
        title=entry["name"],
        headline=entry["headline"],
        link=entry["page"],
        under=f"{synthetic}{entry['written']}",
        tone=entry["tone"],
        lines=entry["lines"],
        cautions=entry["cautions"],
        command=entry["command"],
        picture=entry["picture"],
    )


def index_page(data: Mapping[str, Any]) -> str:
    """Make the page from the result of `index_numbers`."""
    return document_page(index_document(data), {}, CARDS)


def _line(index: Index) -> str:
    return f"{count_words(len(index.entries), 'result')} in {index.folder}"


PRESENTER = Presenter(
    name="",
    numbers=index_numbers,
    document=index_document,
    line=_line,
    texts=lambda _index, data: {PAGE_NAME: index_page(data)},
)
