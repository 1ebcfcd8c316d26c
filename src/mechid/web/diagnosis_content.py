"""Page content for a diagnosis: named effects with the explained misfit, and other effects that were tried."""

from __future__ import annotations

from typing import Any

from mechid.ink.digits import plain
from mechid.web.named_effect import OF_RECORDS, NamedEffect
from mechid.web.stored_diagnosis import StoredDiagnosis

Data = dict[str, Any]


def diagnosed_data(said: StoredDiagnosis) -> Data:
    """Return the lists of the page; the state of the switches is sent with the other changing data."""
    return {
        "words": said.words,
        "effects": [_entry(one) for one in said.effects],
        "tried": [{**one, "words": sentence(one["words"])} for one in said.tried],
    }


def _entry(one: NamedEffect) -> Data:
    hover = one.why_fixed or "Off: there is nothing of it. On: the values found."
    if one.is_of_records:
        hover = f"{hover}{'' if hover.endswith('.') else '.'} {sentence(OF_RECORDS)}."
    return {
        "name": one.name,
        "words": sentence(one.words),
        "explains": f"Explains {plain(100.0 * one.share, 3)} % of the misfit",
        "aliases": [f"{words} ({name})" if words else name for name, words in one.aliases.items()],
        "sliders": [] if one.is_of_records and one.why_fixed else _sliders(one),
        "fixed": bool(one.why_fixed),
        "why_fixed": sentence(one.why_fixed),
        "hover": sentence(hover),
    }


def _sliders(one: NamedEffect) -> list[tuple[str, str]]:
    """Return each table of an effect's parameters, with its first parameter."""
    tables = [name.rpartition(".")[0] for name in one.found]
    firsts = dict(reversed([*zip(tables, one.found, strict=True)]))
    return [(table, firsts[table]) for table in dict.fromkeys(tables)]


def sentence(words: str) -> str:
    """Capitalise the first letter.

    Examples
    --------
    >>> sentence("the supply sags")
    'The supply sags'
    """
    return words[:1].upper() + words[1:]
