"""Options of a target as the command line gives them: texts by name."""

from __future__ import annotations

from collections.abc import Sequence

from mechid.errors import UsageError, did_you_mean

YES, NO = "yes", "no"


def refuse_unknown(name: str, known: Sequence[str], *, also: str = "") -> None:
    """Raise UsageError for an option that a target has not, with the nearest that it has."""
    if name not in known:
        remedy = did_you_mean(name, known) or f"; the options are {', '.join(known)}{also}"
        raise UsageError(f'--option: found "{name}"{remedy}')


def yes_or_no(name: str, text: str) -> bool:
    """Return whether an option is asked for.

    Raises
    ------
    UsageError
        The text is neither yes nor no.
    """
    if text not in (YES, NO):
        raise UsageError(f'--option {name}: found "{text}"; write {YES} or {NO}')
    return text == YES
