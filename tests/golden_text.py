"""Texts that are kept beside the tests, compared with what is made today, and made anew where asked for."""

import difflib
from pathlib import Path

import pytest

OPTION = "--update-golden"
MOST_LINES = 200
"""Lines of a difference that are shown: more tell nothing that these do not."""


def assert_kept(path: Path, text: str, *, update: bool) -> None:
    """Compare a text with the kept one, or keep it."""
    if update:
        path.write_text(text, encoding="utf-8", newline="\n")
    kept = path.read_text(encoding="utf-8") if path.exists() else ""
    if kept != text:
        pytest.fail(difference(path, kept, text), pytrace=False)


def difference(path: Path, kept: str, text: str) -> str:
    """Return what differs, and what to do about it."""
    lines = list(
        difflib.unified_diff(kept.splitlines(), text.splitlines(), f"kept {path.name}", "made now", lineterm="")
    )
    left = len(lines) - MOST_LINES
    more = [f"... and {left} lines more"] if left > 0 else []
    remedy = (
        f"Where this is meant, make it anew and look at the difference in git: python -m pytest {OPTION} {here(path)}"
    )
    return "\n".join([*lines[:MOST_LINES], *more, "", remedy])


def here(path: Path) -> Path:
    """Return the folder of the tests that keep a text."""
    return path.parent.parent.relative_to(Path(__file__).resolve().parents[1])
