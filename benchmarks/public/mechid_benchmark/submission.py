"""Submissions: the JSON file of an entrant, checked key by key."""

import difflib
import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .tasks import CAMPAIGNS, FORMAT, HELD_OUT, ORDERS, UNITS


class SubmissionError(Exception):
    """A submission is wrong: where, what was found, and the remedy, in one line."""


@dataclass(frozen=True)
class Estimate:
    """One estimated parameter in its unit; `interval` is the 95 % interval, None where none is stated."""

    value: float
    interval: tuple[float, float] | None


@dataclass(frozen=True)
class Emission:
    """Predicted emission of a held-out run: RMS torque and one amplitude for each of `ORDERS`, N m."""

    rms_Nm: float
    lines_Nm: tuple[float, ...]


@dataclass(frozen=True)
class Entry:
    """Results of one campaign."""

    parameters: Mapping[str, Estimate]
    emission: Mapping[str, Emission]
    cpu_s: float | None
    remark: str


@dataclass(frozen=True)
class Submission:
    """Results of a method by campaign; a campaign that was not entered is absent."""

    name: str
    entries: Mapping[str, Entry]


def read_submission(path: Path) -> Submission:
    """Return a submission.

    Raises
    ------
    SubmissionError
        The file cannot be read, is no JSON, lacks a key, or has an unknown key or an impossible number.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise SubmissionError(f"{path}: cannot be read ({_reason(error)}); give a submission in JSON") from None
    try:
        told = json.loads(text, parse_constant=_refuse_constant, object_pairs_hook=_unique_keys)
    except (ValueError, RecursionError) as error:
        raise SubmissionError(f"{path}: is no valid JSON: {error}") from None
    try:
        return _submission(told)
    except SubmissionError as error:
        raise SubmissionError(f"{path}: {error}") from None


def _reason(error: Exception) -> str:
    return error.strerror or str(error) if isinstance(error, OSError) else "it is not UTF-8 text"


def _refuse_constant(word: str) -> float:
    raise ValueError(f"{word} is no number of JSON; leave out a value that is unknown")


def _unique_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    out: dict[str, Any] = {}
    for key, value in pairs:
        if key in out:
            raise ValueError(f"the key {json.dumps(key)} stands twice in one table; remove one")
        out[key] = value
    return out


def _submission(told: Any) -> Submission:
    table = _table(told, "the file", required=("format", "name", "campaigns"), optional=("method",))
    if table["format"] != FORMAT:
        raise SubmissionError(f"format: is {json.dumps(table['format'])}; this version reads {json.dumps(FORMAT)}")
    if not isinstance(table["name"], str) or not table["name"].strip():
        raise SubmissionError("name: is not a text; name the method")
    campaigns = _table(table["campaigns"], "campaigns", optional=CAMPAIGNS)
    if not campaigns:
        raise SubmissionError("campaigns: is empty; enter at least one campaign, 01 to 10")
    return Submission(table["name"], {key: _entry(one, f"campaigns.{key}") for key, one in campaigns.items()})


def _entry(told: Any, where: str) -> Entry:
    table = _table(told, where, required=("parameters",), optional=("emission", "cpu_s", "remark"))
    parameters = _table(table["parameters"], f"{where}.parameters", optional=tuple(UNITS))
    emission = _table(table.get("emission", {}), f"{where}.emission", optional=HELD_OUT)
    cpu_s = table.get("cpu_s")
    return Entry(
        {name: _estimate(one, f"{where}.parameters: {name}") for name, one in parameters.items()},
        {name: _emission(one, f"{where}.emission.{name}") for name, one in emission.items()},
        None if cpu_s is None else _number(cpu_s, f"{where}.cpu_s", least=0.0),
        str(table.get("remark", "")),
    )


def _estimate(told: Any, where: str) -> Estimate:
    table = _table(told, where, required=("value",), optional=("interval",))
    value, interval = _number(table["value"], f"{where}: value"), table.get("interval")
    if interval is None:
        return Estimate(value, None)
    if not isinstance(interval, list) or len(interval) != 2:
        raise SubmissionError(f"{where}: interval: is not a list of two numbers; write [low, high]")
    low, high = (_number(end, f"{where}: interval") for end in interval)
    if not low <= value <= high:
        raise SubmissionError(f"{where}: interval [{low:g}, {high:g}] does not hold the value {value:g}")
    return Estimate(value, (low, high))


def _emission(told: Any, where: str) -> Emission:
    table = _table(told, where, required=("rms_Nm", "lines_Nm"))
    lines = table["lines_Nm"]
    if not isinstance(lines, list) or len(lines) != len(ORDERS):
        orders = ", ".join(f"{order:g}" for order in ORDERS)
        raise SubmissionError(f"{where}.lines_Nm: is not a list of {len(ORDERS)} numbers, one for each of {orders}")
    return Emission(
        _number(table["rms_Nm"], f"{where}.rms_Nm", least=0.0),
        tuple(_number(line, f"{where}.lines_Nm", least=0.0) for line in lines),
    )


def _table(told: Any, where: str, *, required: Iterable[str] = (), optional: Iterable[str] = ()) -> Mapping[str, Any]:
    """Return a JSON object whose keys are all known and which has the required ones."""
    if not isinstance(told, dict):
        raise SubmissionError(f"{where}: is not an object {{...}}")
    known = [*required, *optional]
    for key in told:
        if key not in known:
            near = difflib.get_close_matches(key, known, n=1)
            hint = f"did you mean {json.dumps(near[0])}?" if near else f"known are {', '.join(known)}"
            raise SubmissionError(f"{where}: unknown key {json.dumps(key)}; {hint}")
    for key in required:
        if key not in told:
            raise SubmissionError(f"{where}: lacks the key {json.dumps(key)}")
    return told


def _number(told: Any, where: str, least: float = -math.inf) -> float:
    """Return a finite number not below a limit; JSON's true is none."""
    if isinstance(told, bool) or not isinstance(told, int | float):
        raise SubmissionError(f"{where}: {json.dumps(told)[:60]} is not a number")
    try:
        value = float(told)
    except OverflowError:
        value = math.inf
    if not math.isfinite(value) or value < least:
        limit = "finite number" if least == -math.inf else f"finite number of at least {least:g}"
        raise SubmissionError(f"{where}: {json.dumps(told)[:60]} is not a {limit}")
    return value
