"""What the files lack and a fit has: disturbances that they do not declare, terms beside the mechanism."""

from __future__ import annotations

from statistics import median
from typing import Any

from mechid.identification.result.estimate_file import FILE_NAME as ESTIMATE
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import Grade
from mechid.identification.result.missing import Missing, OwnValue
from mechid.identification.result.terms_beside import CLEAR, TermBeside, TermsBeside
from mechid.reports.digits import with_sigma

WITHOUT = (
    "These records ask for more than the mechanism file has: they are followed with the further terms below, which a "
    "real mechanism or its test stand may have."
)
TRUST = (
    "The values of the parameters and their errors hold with these terms: they were found together, so "
    "that an error counts what a term may take away from its parameter. Everything else is without the terms: the "
    "curves and residuals of the records, the estimated mechanism file, and whatever is simulated with it."
)
CLEAR_WORDS = (
    f"A clear term is at least {CLEAR:g} standard errors from nothing: most likely the mechanism has it, or something "
    "much like it. Where that makes sense for yours, write the term into the mechanism file, as the documentation of "
    "its block shows, and identify again."
)
NONE_CLEAR = (
    f"None of them is clear by itself, at least {CLEAR:g} standard errors from nothing: together they stand for "
    "something that mechid cannot name. Look at the residuals' spectra and orders for what it may be."
)
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
OTHER_WORDS = "No different from nothing within their errors, so leave them out of the mechanism file:"


def lacking_lines(fit: Fit) -> list[str]:
    """Return what a fit of grade B or C says that its model is missing, a line each; none of another one."""
    if fit.grade not in (Grade.B, Grade.C):
        return []
    lines = [f"{_capital(one.words)} ({one.name}): estimated with the rest, as below." for one in fit.missing]
    clear = fit.beside.clear if fit.beside else ()
    lines += [
        f"{_capital(fit.beside.words[name])} ({name}): a clear term beside the mechanism file."
        for name in clear
        if fit.beside
    ]
    lines += [
        f"{_capital(one.words)} ({one.name}): by its derivative alone it takes {100.0 * one.share:.2g} % of what "
        f"is left (chi-square {one.chi_square:.3g} for {one.dof}); no fit has tested it."
        for one in fit.suggested
    ]
    return [*(lines or [NOTHING_NAMED]), DIAGNOSE if fit.completed is None else COMPLETED]


def _capital(words: str) -> str:
    return f"{words[:1].upper()}{words[1:]}"


def missing_data(one: Missing) -> dict[str, Any]:
    """Return what the files do not declare and the fit has, with the text of its values."""
    rows = [_row(name, p) for name, p in one.parameters.items()]
    chi_square, share = f"{one.chi_square:.4g}", f"{100.0 * one.share:.3g}"
    text = {"chi_square": chi_square, "share_percent": share, "apart": _most_apart(one)}
    return {**one.to_dict(), "rows": rows, "text": text}


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


def beside_data(beside: TermsBeside | None) -> dict[str, Any] | None:
    """Return the terms that a fit has beside the mechanism as written, the clearest first; None where there are none.

    Returns
    -------
    dict
        ``said``: what they are, what to trust, what to do, a sentence or more each. ``clear_terms``, ``other_terms``:
        their parameters, each with its ``term``, what that is (``words``), and ``meaning``. ``other_words``: what is
        said of the others.
    """
    if beside is None:
        return None
    rows = {
        name: [_term_row(n, p, beside.words[name]) for n, p in beside.parameters.items() if p.term == name]
        for name in beside.names
    }
    clear = beside.clear
    return {
        "said": [WITHOUT, TRUST, CLEAR_WORDS if clear else NONE_CLEAR],
        "clear_terms": [row for name in clear for row in rows[name]],
        "other_terms": [row for name in beside.names if name not in clear for row in rows[name]],
        "other_words": OTHER_WORDS,
    }


def beside_comment(beside: TermsBeside | None) -> list[str]:
    """Return what the estimated mechanism file says of terms that its fit has and it does not, a line or none."""
    if beside is None:
        return []
    clear = f", the clear ones {', '.join(beside.clear)}" if beside.clear else ""
    return [
        f"INCOMPLETE: the values were found together with terms that this file lacks{clear}; {ESTIMATE} lists them."
    ]


def _term_row(name: str, p: TermBeside, words: str) -> dict[str, Any]:
    return {**_row(name, p), "term": p.term, "words": words, "meaning": p.meaning, "width": p.width}


def _row(name: str, p: OwnValue | TermBeside) -> dict[str, Any]:
    """Return a parameter that no table of the mechanism or the campaign has, with the text of its value."""
    value, error = with_sigma(p.value, p.std_error)
    unit = "" if p.unit == "1" else p.unit
    own = {"name": name, "value": p.value, "std_error": p.std_error, "unit": p.unit}
    return {**own, "text": {"value": value, "std_error": error, "unit": unit}}
