"""Scores of a submission: parameter errors, errors of the held-out emission, coverage of the stated intervals."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any

from .submission import Emission, Entry, Submission
from .tasks import CAMPAIGNS, LEVEL, UNITS, is_angle


@dataclass(frozen=True)
class Score:
    """Score of one campaign, or of all.

    Attributes
    ----------
    asked, given : int
        Parameters that are asked for, and those that the submission gives.
    median_percent, worst_percent : float or None
        Errors of the given parameters, in per cent of the truth; of an angle in hundredths of a radian.
    worst : str
        Name of the parameter of the worst error.
    stated, held : int
        Intervals that are stated, and those that hold the truth.
    width_percent : float or None
        Median half-width of the stated intervals, in the errors' measure.
    emission_percent, worst_emission_percent : float or None
        Median and worst over the held-out runs that are given: distance between predicted and true line amplitudes, in
        per cent of the true ones, both root sums of squares.
    rms_percent : float or None
        Worst error of the RMS torque over the same runs, in per cent.
    runs : int
        Held-out runs that are given.
    cpu_s : float or None
    remark : str
    """

    asked: int
    given: int
    median_percent: float | None
    worst_percent: float | None
    worst: str
    stated: int
    held: int
    width_percent: float | None
    emission_percent: float | None
    worst_emission_percent: float | None
    rms_percent: float | None
    runs: int
    cpu_s: float | None
    remark: str


def score_submission(submission: Submission, answers: Mapping[str, Any]) -> dict[str, Any]:
    """Return every number of the score as one plain dict: ``name``, ``campaigns``, ``all``.

    A campaign that was not entered has no score; in ``all`` it counts as asked and not given.
    """
    errors = {key: _errors(entry, answers[key]) for key, entry in submission.entries.items()}
    scores = {key: _score([errors[key]], [submission.entries[key]]) for key in CAMPAIGNS if key in errors}
    whole = _score(list(errors.values()), list(submission.entries.values()), asked=len(CAMPAIGNS) * len(UNITS))
    return {
        "name": submission.name,
        "level": LEVEL,
        "campaigns": {key: asdict(score) for key, score in scores.items()},
        "all": asdict(whole),
    }


@dataclass(frozen=True)
class _Errors:
    """Errors of one campaign: by parameter; half-widths and hits of intervals; of lines and RMS by held-out run."""

    parameters: Mapping[str, float]
    widths: tuple[float, ...]
    hits: tuple[bool, ...]
    lines: tuple[float, ...]
    rms: tuple[float, ...]


def _errors(entry: Entry, answer: Mapping[str, Any]) -> _Errors:
    truth, emission = answer["parameters"], answer["emission"]
    stated = {name: one for name, one in entry.parameters.items() if one.interval}
    return _Errors(
        {name: abs(error_percent(name, one.value, truth[name])) for name, one in entry.parameters.items()},
        tuple(0.5 * (one.interval[1] - one.interval[0]) * _percent(name, truth[name]) for name, one in stated.items()),
        tuple(holds(name, one.interval, truth[name]) for name, one in stated.items()),
        tuple(lines_percent(one, emission[name]) for name, one in entry.emission.items()),
        tuple(100.0 * abs(one.rms_Nm / emission[name]["rms_Nm"] - 1.0) for name, one in entry.emission.items()),
    )


def error_percent(name: str, value: float, true: float) -> float:
    """Return value less truth in per cent of the truth; of an angle the short way round, in hundredths of a radian."""
    return _difference(name, value, true) * _percent(name, true)


def _percent(name: str, true: float) -> float:
    """Return per cent per unit of a parameter."""
    return 100.0 * math.radians(1.0) if is_angle(name) else 100.0 / abs(true)


def _difference(name: str, value: float, true: float) -> float:
    off = value - true
    return (off + 180.0) % 360.0 - 180.0 if is_angle(name) else off


def holds(name: str, interval: tuple[float, float], true: float) -> bool:
    """Return whether an interval holds the truth; that of an angle may lie any number of turns away."""
    low, high = interval
    if is_angle(name):
        return (true - low) % 360.0 <= high - low
    return low <= true <= high


def lines_percent(found: Emission, true: Mapping[str, Any]) -> float:
    """Return the distance between predicted and true line amplitudes in per cent of the length of the true ones."""
    return 100.0 * math.dist(found.lines_Nm, true["lines_Nm"]) / math.hypot(*true["lines_Nm"])


def _score(errors: list[_Errors], entries: list[Entry], asked: int = len(UNITS)) -> Score:
    """Return the score of some campaigns together."""
    named = [(error, name) for one in errors for name, error in one.parameters.items()]
    hits = [hit for one in errors for hit in one.hits]
    lines = [error for one in errors for error in one.lines]
    worst, name = max(named, default=(None, ""))
    seconds = [entry.cpu_s for entry in entries]
    return Score(
        asked=asked,
        given=len(named),
        median_percent=_median(error for error, _ in named),
        worst_percent=worst,
        worst=name,
        stated=len(hits),
        held=sum(hits),
        width_percent=_median(width for one in errors for width in one.widths),
        emission_percent=_median(lines),
        worst_emission_percent=max(lines, default=None),
        rms_percent=max((error for one in errors for error in one.rms), default=None),
        runs=len(lines),
        cpu_s=None if None in seconds else sum(seconds),
        remark="; ".join(dict.fromkeys(entry.remark for entry in entries if entry.remark)) if len(entries) == 1 else "",
    )


def _median(numbers: Iterable[float]) -> float | None:
    found = list(numbers)
    return median(found) if found else None


def table(score: Mapping[str, Any]) -> str:
    """Return the score as a Markdown table, one row a campaign."""
    rows = [
        "| campaign | given | median error % | worst error % | intervals hold | half-width % "
        "| lines off %, median, worst | RMS off % | CPU s | remark |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for key in CAMPAIGNS:
        one = score["campaigns"].get(key)
        rows.append(_row(key, one) if one else f"| {key} | not entered |" + " |" * 8)
    return "\n".join([*rows, _row("all", score["all"])])


def _row(key: str, one: Mapping[str, Any]) -> str:
    worst = f"{_digits(one['worst_percent'])} {one['worst']}".strip()
    cells = [
        key,
        f"{one['given']} of {one['asked']}",
        _digits(one["median_percent"]),
        worst,
        f"{one['held']} of {one['stated']}",
        _digits(one["width_percent"]),
        f"{_digits(one['emission_percent'])}, {_digits(one['worst_emission_percent'])}"
        if one["runs"]
        else "none given",
        _digits(one["rms_percent"]),
        _digits(one["cpu_s"]),
        one["remark"],
    ]
    return "| " + " | ".join(cells) + " |"


def _digits(number: float | None) -> str:
    return "-" if number is None else f"{number:.3g}"
