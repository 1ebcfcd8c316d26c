"""Verdict of each kind of result in a sentence, from the numbers in its file.

A file may have been damaged: a KeyError, TypeError, ValueError or AttributeError says so.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from mechid.identification.result.grade import GRADE_WORDS, Grade
from mechid.ink.digits import digits
from mechid.ink.document import BAD, CAUTION, GOOD

Data: TypeAlias = Mapping[str, Any]
SHOWN, LETTERS = 3, 240
"""Lines of a card, and letters of a line, at most."""
TONES = {Grade.A: GOOD, Grade.B: GOOD, Grade.C: CAUTION, Grade.FAILED: BAD}


@dataclass(frozen=True)
class Verdict:
    """What a result comes to: a sentence, its tone, further lines."""

    headline: str
    tone: str = ""
    lines: tuple[str, ...] = ()


Judged: TypeAlias = Callable[[Data], Verdict]


def campaign_verdict(data: Data) -> Verdict:
    """Return how many records a campaign file names, and whether it has still to be filled in."""
    uses = [str(record.get("use", "estimate")) for record in data["record"]]
    estimated = uses.count("estimate")
    headline = f"{counted(estimated, 'record')} to estimate from, {len(uses) - estimated} to validate with"
    blank = any(record.get("command") == {} or record.get("channels") == [] for record in data["record"])
    return Verdict(headline, CAUTION, ("It is a template still: fill it in.",)) if blank else Verdict(headline)


def check_verdict(data: Data) -> Verdict:
    """Return how many warnings there are of a campaign as it was understood."""
    warnings, free = data["warnings"], counted(len(data["free"]), "parameter")
    headline = f"{counted(len(data['records']), 'record')}, {free} to be estimated"
    return Verdict(headline, CAUTION if warnings else GOOD, _few(warnings))


def fit_verdict(data: Data) -> Verdict:
    """Return the grade of a fit, what it says, and the reasons for it."""
    grade = Grade(data["grade"])
    headline, _, words = GRADE_WORDS[grade].partition(": ")
    return Verdict(headline, TONES[grade], _few([words, *(one["text"] for one in data["grade_reasons"])]))


def diagnosis_verdict(data: Data) -> Verdict:
    """Return what a mechanism file lacks."""
    missing = [f"{one['words']} ({one['name']})" for one in data["missing"]]
    headline = f"{counted(len(missing), 'effect')} missing" if missing else "no missing effect is named"
    good = not missing and not data["unexplained"]["share"]
    return Verdict(headline, GOOD if good else CAUTION, _few([*missing, data["unexplained"]["words"]]))


def comparison_verdict(data: Data) -> Verdict:
    """Return which fit the records prefer."""
    preferred = f" Preferred: {data['preferred']}." if data["preferred"] else ""
    tone = GOOD if data["preferred"] and not data["cautions"] else CAUTION
    return Verdict(data["outcome"]["message"] + preferred, tone, _few([", ".join(data["hypotheses"])]))


def profile_verdict(data: Data) -> Verdict:
    """Return of which parameters there are profiles, and their warnings."""
    return _with_warnings(f"profiles of {', '.join(data['profiles'])}", data["warnings"])


def bootstrap_verdict(data: Data) -> Verdict:
    """Return how many draws converged, and the warnings."""
    return _with_warnings(f"{data['tally']['converged']} of {data['draws']} draws converged", data["warnings"])


def design_verdict(data: Data) -> Verdict:
    """Return the records that are proposed and what they gain."""
    chosen, gain = data["chosen"], data["gain_factor"]
    names = ", ".join(record["name"] for record in chosen["records"])
    count = counted(len(chosen["records"]), "record")
    return Verdict(f"{count} in {chosen['seconds']:.0f} s: errors {digits(gain, 3)} times smaller", "", _few([names]))


def budget_verdict(data: Data) -> Verdict:
    """Return how many requirements are met, and the least margin."""
    decided = [(one["decided"]["margin"], one) for one in data["requirements"]]
    if not decided:
        return Verdict("no requirement is given; the disturbance alone is shown", "", _few(data["warnings"]))
    met = sum(bool(one["decided"]["met"]) for _, one in decided)
    margin, least = min(decided, key=lambda pair: float(pair[0]))
    where = f"least margin {100.0 * margin:.1f} %: {least['requirement']}, {least['mode']}, {least['axis']}"
    tone = BAD if margin < 0.0 else GOOD if met == len(decided) and not data["warnings"] else CAUTION
    return Verdict(f"{met} of {len(decided)} requirements met", tone, _few([where, *data["warnings"]]))


def emission_verdict(data: Data) -> Verdict:
    """Return how many requirements on the emission are shown to be met, and which are not."""
    verdicts = [(str(one["name"]), str(one["verdict"])) for one in data["requirements"]]
    open_ones = [f"{name}: {verdict.replace('_', ' ')}" for name, verdict in verdicts if verdict != "pass"]
    failed = any(verdict == "fail" for _, verdict in verdicts)
    headline = f"{len(verdicts) - len(open_ones)} of {len(verdicts)} requirements shown to be met"
    tone = BAD if failed else CAUTION if open_ones else GOOD
    return Verdict(headline, tone, _few([*open_ones, *data["notes"]]))


def fleet_verdict(data: Data) -> Verdict:
    """Return how many campaigns have an estimate, which parameters differ and which units stand off."""
    failed, parameters = data["failed"], data["parameters"]
    differ = [one["name"] for one in parameters if one["differs"]]
    outliers = sorted({str(outlier["unit"]) for one in parameters for outlier in one["outliers"]})
    lines = [f"differ from unit to unit: {', '.join(differ)}"] if differ else []
    lines += [f"stand off: {', '.join(outliers)}"] if outliers else []
    tone = BAD if failed else CAUTION if outliers or data["cautions"] else GOOD
    whole = len(data["campaigns"])
    return Verdict(f"{whole - len(failed)} of {counted(whole, 'campaign')} have an estimate to use", tone, _few(lines))


def look_verdict(data: Data) -> Verdict:
    """Return which records were looked at, and their warnings."""
    records, left_out = data["records"], data["left_out"]
    count = counted(len(records), "record")
    headline = f"{count}, {len(left_out)} could not be read" if left_out else count
    warnings = [f"{one['name']}: {line}" for one in records for line in one["warnings"]]
    lines = [", ".join(str(one["name"]) for one in records), *warnings]
    return Verdict(headline, BAD if left_out else CAUTION if warnings else "", _few(lines))


def simulation_verdict(data: Data) -> Verdict:
    """Return which records were simulated, and warnings of their accuracy."""
    records, warnings = data["records"], data["warnings"]
    names = ", ".join(str(one["name"]) for one in records)
    return Verdict(
        f"{counted(len(records), 'record')} simulated", CAUTION if warnings else "", _few([names, *warnings])
    )


def export_verdict(data: Data) -> Verdict:
    """Return what was written for whom, and what it was compared with."""
    checked = data["checked"]
    against = f"checked against {checked['against']}" if checked else "not checked"
    tone = GOOD if checked else CAUTION
    return Verdict(f"{counted(len(data['files']), 'file')} for {data['target']}", tone, _few([against, *data["words"]]))


def counted(count: int, what: str) -> str:
    """Return a count with its noun.

    Examples
    --------
    >>> counted(1, "record"), counted(2, "record")
    ('1 record', '2 records')
    """
    return f"{count} {what}{'s' * (count != 1)}"


def _with_warnings(headline: str, warnings: Sequence[str]) -> Verdict:
    return Verdict(headline, CAUTION if warnings else GOOD, _few(warnings))


def _few(lines: Sequence[str]) -> tuple[str, ...]:
    """Return the first lines, and how many more there are; TypeError where they are none."""
    kept = [line for line in lines if line]
    if any(not isinstance(line, str) for line in kept):
        raise TypeError("a line of words")
    more = len(kept) - SHOWN
    shown = (line if len(line) <= LETTERS else f"{line[:LETTERS].rstrip()} ..." for line in kept[:SHOWN])
    return (*shown, *([f"and {more} more"] if more > 0 else []))
