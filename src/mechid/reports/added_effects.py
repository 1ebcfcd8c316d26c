"""Effects that a fit has added to its files: disturbances of the records, and terms of the mechanism."""

from __future__ import annotations

import math

from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import Grade
from mechid.identification.result.missing_effects import AsWritten, Missing

LACKING = "What the model is missing"
NOTHING_NAMED = "No effect that mechid knows stands out by itself."
DIAGNOSE = (
    '"mechid diagnose" with the result folder fits the effects of the library with all else, says which are needed '
    "and which these records cannot tell apart, and proposes a mechanism file; "
    '"mechid identify --complete" goes on with it.'
)
COMPLETED = "The mechanism was completed by what the records ask for; this is what they ask for beyond."


def residual_lines(fit: Fit) -> list[str]:
    """Return the missing effects of a fit of grade B or C, one line each; empty for other grades."""
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
    """Return a sentence on the misfit of the mechanism as written; empty if the fit added nothing."""
    if found is None:
        return []
    ratios = [ratio for ratio in found.residual_over_noise.values() if math.isfinite(ratio)]
    follows = "follows the records too" if found.follows else "does not follow all records"
    size = f" and leaves {min(ratios):.3g} to {max(ratios):.3g} times their noise" if ratios else ""
    return [f"The mechanism file as written, at the same values, {follows}{size}."]


def _capital(words: str) -> str:
    return f"{words[:1].upper()}{words[1:]}"


def added_notes(fit: Fit) -> dict[str, str]:
    """Return remarks on added terms for the estimated mechanism file, by dotted name of parameter or option."""
    notes: dict[str, str] = {}
    for one in fit.added_terms:
        note = f"added by mechid: {one.words}; the records need it (chi-square {one.chi_square:.4g} for {one.dof})"
        places = {name.rpartition(".")[0] for name in one.parameters}
        # A parameter that came with a block keeps the remark of the first term there; a term's own take that term's.
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
    """Return the line on added terms in the head of the estimated mechanism file, if there are any."""
    added = [one.name for one in fit.added_terms]
    if not added:
        return []
    return [f"ADDED to the mechanism as written, because the records need it: {', '.join(added)}."]
