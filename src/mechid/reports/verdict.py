"""Verdict on a fit in sentences: quality, largest uncertainty, and possible improvement."""

from __future__ import annotations

import math
from typing import Any

from mechid.analysis.noise_floor_test import NoiseComparison, NoiseLevel
from mechid.identification.uncertainty.settings import NOISE
from mechid.ink.data import Data
from mechid.ink.digits import digits, plain
from mechid.ink.document import BAD, CAUTION, GOOD
from mechid.ink.quantities import has_only_torque, quantity_words
from mechid.reports.added_effects import LACKING
from mechid.reports.details import worst_pair
from mechid.reports.noise import above_words, compare_with_noise
from mechid.reports.use import held_out, left_out, left_out_words

TONES = {"A": GOOD, "B": CAUTION}
READ_CAUTIONS = "Read the cautions before its values are used."
STRONG = 0.95
COLOURED = 1.5
"""Ratio of the standard error for coloured noise to that for white noise above which residuals count as coloured."""
WORTH = 0.98
"""Largest factor on a standard error at which a further record is proposed."""

Residuals = list[tuple[Data, NoiseComparison]]
"""The rows of a validation, each with its residual beside the record's noise."""


def summary_data(data: Data) -> dict[str, Any]:
    """Return the verdict of a report: grade, tone, headline, and answers to three questions.

    For an incomplete model, a fourth question lists its missing effects.

    Parameters
    ----------
    data : mapping
        The report's, with ``correlation`` and ``information``.
    """
    residuals = _residuals(data)
    tone, headline = verdict(data)
    return {
        "grade": data["grade"],
        "tone": tone,
        "headline": headline,
        "questions": [
            {"question": "Is this fit good?", "answers": _quality(data, residuals)},
            {"question": "What is least certain?", "answers": _uncertain(data)},
            {"question": "What would improve it?", "answers": _improvement(data, residuals)},
            *([{"question": LACKING, "answers": data["lacking"]}] if data["lacking"] else []),
        ],
    }


def verdict(data: Data) -> tuple[str, str]:
    """Return the tone and the headline for the result of `report_data`."""
    tone = _tone(data, _residuals(data))
    careful = data["grade"] == "A" and tone != GOOD
    return tone, f"{data['grade_words']} {READ_CAUTIONS}" if careful else data["grade_words"]


def _residuals(data: Data) -> Residuals:
    return [(row, compare_with_noise(data, row)) for row in data["validation"]]


def least_certain(data: Data) -> Data | None:
    """Return the free parameter with the largest relative error; that of an angle is in radians."""
    free = [row for row in data["parameters"] if row["std_error"]]
    return max(free, key=relative_error, default=None)


def relative_error(row: Data) -> float:
    """Return a parameter's standard error relative to its value, an angle's in radians."""
    # The zero of an angle is arbitrary, so its error is not divided by its value.
    if row["unit"] == "deg":
        return math.radians(row["std_error"])
    return float(row["std_error"] / abs(row["estimate"])) if row["estimate"] else math.inf


def _tone(data: Data, residuals: Residuals) -> str:
    """Return the tone of the verdict; a complete model with cautions is not `GOOD`."""
    tone = TONES.get(data["grade"], BAD)
    if tone != GOOD:
        return tone
    unsure = any(row["status"] in ("at_bound", "frozen") or row["local_only"] for row in data["parameters"])
    unexplained = any(not residual.is_noise for _, residual in residuals)
    return CAUTION if unexplained or unsure or _coloured_parameters(data) or data["warnings"] else GOOD


def _quality(data: Data, residuals: Residuals) -> list[str]:
    rows = data["validation"]
    ratios = [r.ratio for _, r in residuals if r.level is not NoiseLevel.LOST]
    said = [reason["text"] for reason in data["reasons"]]
    message = data["outcome"]["message"]
    lines = said if any(text.startswith(message) for text in said) else [message, *said]
    if ratios:
        within = sum(r.is_noise for _, r in residuals)
        what = "records" if has_only_torque(rows) else "channels"
        size = f"the residual is {min(ratios):.2f} to {max(ratios):.2f} times the noise floor."
        explained = f"{within} of {len(rows)} {what} are explained down to their noise: {size}"
        lines.append(explained if data["grade"] == "A" else _capital(size))
    lines += [
        f"Record {_name_words(row)}: the simulation does not come to its end."
        for row, residual in residuals
        if residual.level is NoiseLevel.LOST
    ]
    lines += [_misfit(row, residual) for row, residual in _misfits(data, residuals)]
    lines += [left_out_words(_name_words(row), row["text"]["fit_percent"]) for row in left_out(rows)]
    tested = held_out(rows)
    lines += [_prediction_words(row) for row in tested]
    if rows and not tested:
        lines.append('No record was held out (use = "validate"): the prediction of new records is not tested.')
    return lines


def _prediction_words(row: Data) -> str:
    """Return a sentence on the prediction of a held-out record, and on its fitted first part, if any."""
    fit = f"predicted with a fit of {row['text']['fit_percent']} %."
    if row.get("judged_from_s") is None:
        return f"Record {_name_words(row)} was held out and is {fit}"
    own, until = ", ".join(row["fitted_of_its_own"]), digits(row["judged_from_s"], 4)
    return f"Record {_name_words(row)} was held out: {own} fitted on its first part, up to {until} s; the rest is {fit}"


def _capital(sentence: str) -> str:
    return f"{sentence[0].upper()}{sentence[1:]}"


def _misfits(data: Data, residuals: Residuals) -> Residuals:
    """Return the channels above the noise, without left-out records, which the model cannot follow."""
    above = (NoiseLevel.COLOURED, NoiseLevel.ABOVE)
    return [(row, r) for row, r in residuals if r.level in above and not row["left_out"]]


def _misfit(row: Data, residual: NoiseComparison) -> str:
    where = ""
    if row["bands"] and residual.ratio > NOISE.misfit:  # below, the largest band may be that of the noise
        band = max(row["bands"], key=lambda b: float(b["residual_rms"]))
        where = f", most of it in the third octave at {digits(band['centre_hz'], 3)} Hz"
    return f"Record {_name_words(row)}: the residual is {above_words(residual)}{where}."


def _name_words(row: Data) -> str:
    """Return the name of a record, with the channel unless it is the torque."""
    return str(row["name"]) if row["quantity"] == "torque" else f"{row['name']} ({quantity_words(row['quantity'])})"


def _uncertain(data: Data) -> list[str]:
    row, lines = least_certain(data), []
    if row:
        text = row["text"]
        relative = f" ({digits(100.0 * relative_error(row), 2)} %)" if row["unit"] != "deg" else ""
        lines.append(
            f"{row['name']} = {text['estimate']} ± {text['std_error']} {text['unit']}".rstrip() + f"{relative}."
        )
    else:
        lines.append("No parameter has a standard error.")
    lines += [
        f"{p['name']} is {p['text']['status']} at {p['text']['estimate']} {p['text']['unit']}".rstrip()
        + f": {p['reason']}."
        for p in data["parameters"]
        if p["status"] in ("at_bound", "frozen")
    ]
    local = [row["name"] for row in data["parameters"] if row["local_only"]]
    if local:
        lines.append(
            f"Near a stick/slip threshold: the standard errors of {', '.join(local)} hold on this side of it only."
        )
    pair = worst_pair(data["correlation"])
    if pair and abs(pair[2]) >= STRONG:
        lines.append(f"{pair[0]} and {pair[1]} depend on each other most: correlation {pair[2]:+.3f}.")
    coloured = _coloured_parameters(data)
    if coloured:
        lines.append(
            "Residuals are coloured: standard errors that count it exceed those for white noise "
            f"by more than {COLOURED:g} for {', '.join(coloured)}."
        )
    return lines


def _coloured_parameters(data: Data) -> list[str]:
    return [
        row["name"]
        for row in data["parameters"]
        if row["std_error_noise"]
        and row["std_error_white"]
        and row["std_error_noise"] > COLOURED * row["std_error_white"]
    ]


def _improvement(data: Data, residuals: Residuals) -> list[str]:
    lines = [f"Next: {reason['next_command']}." for reason in data["reasons"][:1]]
    lines += [
        f"A model of what record {_name_words(row)} still contains: look at its residual's spectrum and at its orders."
        for row, _ in _misfits(data, residuals)
    ]
    lines += [
        f"Knowing how record {_name_words(row)} was commanded and wired: the warnings say what was tried."
        for row in left_out(data["validation"])
    ]
    row, information = least_certain(data), data["information"]
    if row and information and row["name"] in information["parameters"]:
        lines += _records_to_add(row["name"], information)
    lines += [f"{p['name']}: {p['reason']}." for p in data["parameters"] if p["status"] == "frozen"]
    return lines or ["Nothing that these records show."]


def _records_to_add(name: str, information: Data) -> list[str]:
    """Name the record whose repetition helps most, and the one that helps most per second of test."""
    factors = information["repeated"][information["parameters"].index(name)]
    gains = dict(zip(information["records"], factors, strict=True))
    seconds = dict(zip(information["records"], information["duration_s"], strict=True))
    best = min(gains, key=lambda record: float(gains[record]))
    # Negated, so that NaN counts as no gain.
    if not gains[best] < WORTH:
        return [f"No single record repeated once more would lower the standard error of {name} by more than 2 %."]
    lines = [
        f"Recording {best} once more ({plain(seconds[best], 3)} s) would lower the standard error of {name} "
        f"by {_fall(gains[best])} %."
    ]
    short = max(gains, key=lambda record: (1.0 - float(gains[record])) / float(seconds[record]))
    if short != best and gains[short] < WORTH:
        lines.append(f"Per second of test {short} ({plain(seconds[short], 3)} s) helps most: {_fall(gains[short])} %.")
    return lines


def _fall(factor: float) -> str:
    return digits(100.0 * (1.0 - factor), 2)
