"""Effects that the files do not declare and a fit has added: disturbances of the records, terms of the mechanism."""

from __future__ import annotations

import math
from statistics import median
from typing import Any

from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import Grade
from mechid.identification.result.missing import AsWritten, Missing, OwnValue
from mechid.ink.digits import with_sigma

CLEAR = 3.0
"""Standard errors by which a record's value has to differ from the others' to be named; a choice, not measured."""
LACKING = "What the model is missing"
NOTHING_NAMED = "No effect that mechid knows stands out by itself."
DIAGNOSE = (
    '"mechid diagnose" with the result folder fits the effects of the library with all else, says which are needed '
    "and which these records cannot tell apart, and proposes a mechanism file; "
    '"mechid identify --complete" goes on with it.'
)
COMPLETED = "The mechanism was completed by what the records ask for; this is what they ask for beyond."
LEAST_TO_COMPARE = 3
"""Records of which one can be apart from the others."""
CAMPAIGN_FILE, MECHANISM_FILE = "campaign.toml", "mechanism.toml"


def lacking_lines(fit: Fit) -> list[str]:
    """Return what a fit of grade B or C says that its model is missing, a line each; none of another one."""
    if fit.grade not in (Grade.B, Grade.C):
        return []
    lines = [f"{_capital(one.words)} ({one.name}): {_added_words(one)}, as below." for one in fit.missing]
    lines += as_written_lines(fit.as_written)
    lines += [
        f"{_capital(one.words)} ({one.name}): by its derivative alone it takes {100.0 * one.share:.2g} % of what "
        f"is left (chi-square {one.chi_square:.3g} for {one.dof}); no fit has tested it."
        for one in fit.suggested
    ]
    return [*(lines or [NOTHING_NAMED]), DIAGNOSE if fit.completed is None else COMPLETED]


def _added_words(one: Missing) -> str:
    return "added to the mechanism, and estimated with the rest" if one.block else "estimated with the rest"


def as_written_lines(found: AsWritten | None) -> list[str]:
    """Return how the mechanism as the user wrote it does, a sentence; nothing where the fit added nothing to it."""
    if found is None:
        return []
    ratios = [ratio for ratio in found.residual_over_noise.values() if math.isfinite(ratio)]
    follows = "follows the records too" if found.follows else "does not follow all records"
    size = f" and leaves {min(ratios):.3g} to {max(ratios):.3g} times their noise" if ratios else ""
    return [f"The mechanism file as written, at the same values, {follows}{size}."]


def _capital(words: str) -> str:
    return f"{words[:1].upper()}{words[1:]}"


def missing_data(one: Missing) -> dict[str, Any]:
    """Return what the files do not declare and the fit has, with the text of its values."""
    rows = [_row(name, p) for name, p in one.parameters.items()]
    chi_square, share = f"{one.chi_square:.4g}", f"{100.0 * one.share:.3g}"
    file = MECHANISM_FILE if one.block else CAMPAIGN_FILE
    text = {"chi_square": chi_square, "share_percent": share, "apart": _most_apart(one), "file": file}
    text["where"] = _where(one, file)
    return {**one.to_dict(), "rows": rows, "text": text}


def _where(one: Missing, file: str) -> str:
    """Return where the text that declares an effect belongs; one of comments alone has its table in the file."""
    is_comment = all(line.startswith("#") for line in one.toml.splitlines())
    return f"in the table that {file} has already" if is_comment else f"at the end of {file}"


def _most_apart(one: Missing) -> str:
    """Return whose value is furthest from the others', as a sentence's end; empty where no record stands out."""
    own = {n: (p.value, p.std_error) for n, p in one.parameters.items() if n.startswith("record.") and p.std_error}
    if len(own) < LEAST_TO_COMPARE:
        return ""
    middle = median(value for value, _ in own.values())
    apart = {name: abs(value - middle) for name, (value, error) in own.items() if abs(value - middle) >= CLEAR * error}
    if not apart:
        return ""
    name = max(apart, key=lambda name: apart[name])
    value, error = with_sigma(*own[name])
    unit = "" if one.parameters[name].unit == "1" else f" {one.parameters[name].unit}"
    return f", most of all in {name.split('.')[1]}: {value} +- {error}{unit}"


def added_notes(fit: Fit) -> dict[str, str]:
    """Return remarks for the estimated mechanism file on what the fit added, by dotted name of parameter or option."""
    notes: dict[str, str] = {}
    for one in fit.added_terms:
        note = f"added by mechid: {one.words}; the records need it (chi-square {one.chi_square:.4g} for {one.dof})"
        places = {name.rpartition(".")[0] for name in one.parameters}
        notes |= {
            n: note for n, p in fit.parameters.items() if p.added and n.rpartition(".")[0] in places and n not in notes
        }
        notes |= {
            option: note
            for option, law in fit.mechanism.options.items()
            if one.name == f"{one.block}.{law}" and option.rpartition(".")[0] == one.block
        }
        notes |= dict.fromkeys(one.parameters, note)
    return notes


def added_comment(fit: Fit) -> list[str]:
    """Return what the head of the estimated mechanism file says of added terms, a line or none."""
    added = [one.name for one in fit.added_terms]
    if not added:
        return []
    return [f"ADDED to the mechanism as written, because the records need it: {', '.join(added)}."]


def _row(name: str, p: OwnValue) -> dict[str, Any]:
    """Return a parameter that no table of the mechanism or the campaign has, with the text of its value."""
    value, error = with_sigma(p.value, p.std_error)
    unit = "" if p.unit == "1" else p.unit
    own = {"name": name, "value": p.value, "std_error": p.std_error, "unit": p.unit}
    return {**own, "text": {"value": value, "std_error": error, "unit": unit}}
