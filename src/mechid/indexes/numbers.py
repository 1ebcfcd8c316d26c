"""Numbers of an index, in one dict."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from mechid.indexes.index import Index


def index_numbers(index: Index) -> dict[str, Any]:
    """Return the content shown by an index."""
    return {
        "folder": str(index.folder),
        "page": str(index.page),
        "synthetic": False,
        "entries": [asdict(entry) for entry in index.entries],
        "unreadable": list(index.unreadable),
    }
