"""Verdicts of all kinds of result, derived from the numbers in their files.

A damaged file raises KeyError, TypeError, ValueError or AttributeError.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from mechid.identification.result.grade import GRADE_WORDS, Grade
from mechid.ink.digits import digits
from mechid.ink.document import BAD, CAUTION, GOOD

Data: TypeAlias = Mapping[str, Any]
# A card shows the essentials; the page of the result has the rest.
MOST_LINES, MOST_LETTERS = 3, 240
"""Most lines of a card, and most characters of a line."""
TONES = {Grade.A: GOOD, Grade.B: GOOD, Grade.C: CAUTION, Grade.FAILED: BAD}
"""Tones of a card, which tells usable fits from others; a report is stricter and shows B as a caution."""


@dataclass(frozen=True)
class Verdict:
    """Verdict of a result: a sentence, its tone, and further lines."""

    headline: str
    tone: str = ""
    lines: tuple[str, ...] = ()


Judged: TypeAlias = Callable[[Data], Verdict]


def campaign_verdict(data: Data) -> Verdict:
    """Count the records of a campaign file, and tell whether it has to be completed."""
    uses = [str(record.get("use", "estimate")) for record in data["record"]]
    estimated = uses.count("estimate")
    headline = f"{count_words(estimated, 'record')} to estimate from, {len(uses) - estimated} to validate with"
    blank = any(record.get("command") == {} or record.get("channels") == [] for record in data["record"])
    return Verdict(headline, CAUTION, ("It is a template still: fill it in.",)) if blank else Verdict(headline)


def check_verdict(data: Data) -> Verdict:
    """Count the warnings of a check."""
    warnings, free = data["warnings"], count_words(len(data["free"]), "parameter")
    headline = f"{count_words(len(data['records']), 'record')}, {free} to be estimated"
    return Verdict(headline, CAUTION if warnings else GOOD, _few(warnings))


def fit_verdict(data: Data) -> Verdict:
    """Return the grade of a fit with its meaning and reasons."""
    grade = Grade(data["grade"])
    headline, _, words = GRADE_WORDS[grade].partition(": ")
    return Verdict(headline, TONES[grade], _few([words, *(one["text"] for one in data["grade_reasons"])]))


def diagnosis_verdict(data: Data) -> Verdict:
    """List the effects missing in a mechanism file."""
    missing = [f"{one['words']} ({one['name']})" for one in data["missing"]]
    headline = f"{count_words(len(missing), 'effect')} missing" if missing else "no missing effect is named"
    good = not missing and not data["unexplained"]["share"]
    return Verdict(headline, GOOD if good else CAUTION, _few([*missing, data["unexplained"]["words"]]))


def comparison_verdict(data: Data) -> Verdict:
    """Name the fit preferred by the records."""
    preferred = f" Preferred: {data['preferred']}." if data["preferred"] else ""
    tone = GOOD if data["preferred"] and not data["cautions"] else CAUTION
    return Verdict(data["outcome"]["message"] + preferred, tone, _few([", ".join(data["hypotheses"])]))


def profile_verdict(data: Data) -> Verdict:
    """List the profiled parameters and their warnings."""
    return _with_warnings(f"profiles of {', '.join(data['profiles'])}", data["warnings"])


def bootstrap_verdict(data: Data) -> Verdict:
    """Count the converged draws, and list warnings."""
    return _with_warnings(f"{data['tally']['converged']} of {data['draws']} draws converged", data["warnings"])


def design_verdict(data: Data) -> Verdict:
    """List the proposed records and their gain."""
    chosen, gain = data["chosen"], data["gain_factor"]
    names = ", ".join(record["name"] for record in chosen["records"])
    count = count_words(len(chosen["records"]), "record")
    return Verdict(f"{count} in {chosen['seconds']:.0f} s: errors {digits(gain, 3)} times smaller", "", _few([names]))


def quiet_verdict(data: Data) -> Verdict:
    """Give the least gain of a microstep table over its design rates, and its bits."""
    least = min(data["gains"], key=lambda one: float(one["gain_db"]))
    gain, bits = digits(float(least["gain_db"]), 3), int(data["table"]["bits"])
    headline = f"RMS torque down by {gain} dB or more at the design rates, with {bits} bits"
    return Verdict(headline, GOOD if float(least["bound_db"]) > 0.0 else CAUTION, _few(data["warnings"]))


def budget_verdict(data: Data) -> Verdict:
    """Count the met requirements, and give the least margin."""
    decided = [(one["decided"]["margin"], one) for one in data["requirements"]]
    # Files of earlier versions have no requirements on the emission.
    exported = emission_verdict({"requirements": data.get("emission_requirements") or [], "notes": data["warnings"]})
    if not decided and data.get("emission_requirements"):
        return exported
    if not decided:
        return Verdict("no requirement is given; the disturbance alone is shown", "", _few(data["warnings"]))
    met = sum(bool(one["decided"]["met"]) for _, one in decided)
    margin, least = min(decided, key=lambda pair: float(pair[0]))
    where = f"least margin {100.0 * margin:.1f} %: {least['requirement']}, {least['mode']}, {least['axis']}"
    tone = BAD if margin < 0.0 else GOOD if met == len(decided) and not data["warnings"] else CAUTION
    headline = f"{met} of {len(decided)} requirements met"
    if data.get("emission_requirements"):
        headline += f"; on the emission {exported.headline}"
        tone = BAD if BAD in (tone, exported.tone) else CAUTION if CAUTION in (tone, exported.tone) else GOOD
    return Verdict(headline, tone, _few([where, *data["warnings"]]))


def emission_verdict(data: Data) -> Verdict:
    """Return how many requirements on the emission are shown to be met, and which are not."""
    verdicts = [(str(one["name"]), str(one["verdict"])) for one in data["requirements"]]
    open_ones = [f"{name}: {verdict.replace('_', ' ')}" for name, verdict in verdicts if verdict != "pass"]
    failed = any(verdict == "fail" for _, verdict in verdicts)
    headline = f"{len(verdicts) - len(open_ones)} of {len(verdicts)} requirements shown to be met"
    tone = BAD if failed else CAUTION if open_ones else GOOD
    return Verdict(headline, tone, _few([*open_ones, *data["notes"]]))


def fleet_verdict(data: Data) -> Verdict:
    """Count the estimated campaigns, and name differing parameters and outliers."""
    failed, parameters = data["failed"], data["parameters"]
    differ = [one["name"] for one in parameters if one["differs"]]
    outliers = sorted({str(outlier["unit"]) for one in parameters for outlier in one["outliers"]})
    lines = [f"differ from unit to unit: {', '.join(differ)}"] if differ else []
    lines += [f"stand off: {', '.join(outliers)}"] if outliers else []
    tone = BAD if failed else CAUTION if outliers or data["cautions"] else GOOD
    whole = len(data["campaigns"])
    return Verdict(
        f"{whole - len(failed)} of {count_words(whole, 'campaign')} have an estimate to use", tone, _few(lines)
    )


def look_verdict(data: Data) -> Verdict:
    """List the examined records and their warnings."""
    records, left_out = data["records"], data["left_out"]
    count = count_words(len(records), "record")
    headline = f"{count}, {len(left_out)} could not be read" if left_out else count
    warnings = [f"{one['name']}: {line}" for one in records for line in one["warnings"]]
    lines = [", ".join(str(one["name"]) for one in records), *warnings]
    return Verdict(headline, BAD if left_out else CAUTION if warnings else "", _few(lines))


def simulation_verdict(data: Data) -> Verdict:
    """List the simulated records and warnings on their accuracy."""
    records, warnings = data["records"], data["warnings"]
    names = ", ".join(str(one["name"]) for one in records)
    return Verdict(
        f"{count_words(len(records), 'record')} simulated", CAUTION if warnings else "", _few([names, *warnings])
    )


def export_verdict(data: Data) -> Verdict:
    """Name the target of an export and its verification."""
    checked = data["checked"]
    against = f"checked against {checked['against']}" if checked else "not checked"
    tone = GOOD if checked else CAUTION
    return Verdict(
        f"{count_words(len(data['files']), 'file')} for {data['target']}", tone, _few([against, *data["words"]])
    )


def count_words(count: int, noun: str) -> str:
    """Return a count with its noun.

    Examples
    --------
    >>> count_words(1, "record"), count_words(2, "record")
    ('1 record', '2 records')
    """
    return f"{count} {noun}{'s' * (count != 1)}"


def _with_warnings(headline: str, warnings: Sequence[str]) -> Verdict:
    return Verdict(headline, CAUTION if warnings else GOOD, _few(warnings))


def _few(lines: Sequence[str]) -> tuple[str, ...]:
    """Return the first lines and the number of further ones; TypeError for other values."""
    kept = [line for line in lines if line]
    # A damaged file may hold other values here; the error marks the result as damaged.
    if any(not isinstance(line, str) for line in kept):
        raise TypeError("a line of words")
    more = len(kept) - MOST_LINES
    shown = (line if len(line) <= MOST_LETTERS else f"{line[:MOST_LETTERS].rstrip()} ..." for line in kept[:MOST_LINES])
    return (*shown, *([f"and {more} more"] if more > 0 else []))
