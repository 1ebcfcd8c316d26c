"""Numbers of a diagnosis, with texts and evidence for the named effects, in one plain dict."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from mechid.analysis.preference import LEVELS, ComparisonOutcome
from mechid.diagnoses.effect_rows import missing_data
from mechid.diagnoses.figures import STRETCH_NAME, hertz, spectrum_name
from mechid.diagnoses.path import path_rows
from mechid.identification.diagnosis.diagnosis import Diagnosis
from mechid.identification.diagnosis.figure_data import FigureData
from mechid.identification.diagnosis.proposal import HeldOut
from mechid.identification.result.diagnosis_file import FORMAT
from mechid.identification.result.estimate_file import provenance_of_fits
from mechid.ink.digits import digits
from mechid.signal.strongest import StrongestParts

LINES, BANDS = "lines", "third octaves around"
BETTER = 0.01
"""Relative difference of residuals from which one predicts better."""


def diagnosis_numbers(found: Diagnosis) -> dict[str, Any]:
    """Return the numbers shown by a diagnosis, with formatted texts."""
    return {
        "format": FORMAT,
        "synthetic": found.synthetic,
        "missing": [_entry(missing_data(one), found.pictures) for one in found.missing],
        "unexplained": {"share": found.unexplained, "words": found.words},
        "over_noise": {"as_written": found.over_noise[0], "with_effects": found.over_noise[1]},
        "evidence": evidence_lines(found),
        "held_out": [asdict(one) for one in found.held_out],
        "locked": [asdict(one) for one in found.locked],
        "tried": [asdict(one) for one in found.tried],
        "as_written": asdict(found.as_written),
        "steps": [asdict(one) for one in found.steps],
        "path": path_rows([asdict(one) for one in found.steps], asdict(found.as_written)) if found.steps else [],
        "drawn": _figure_names(found.pictures),
        "provenance": provenance_of_fits(found.fit_digest),
    }


def plain_numbers(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers without texts, as in diagnose.json."""
    missing = [{k: v for k, v in one.items() if k not in ("rows", "text", "places")} for one in data["missing"]]
    return {**{k: v for k, v in data.items() if k not in ("path", "drawn")}, "missing": missing}


def _entry(data: dict[str, Any], pictures: FigureData) -> dict[str, Any]:
    acts = pictures.acts.get(data["name"], {})
    places = [_place(record, acts[record]) for record in data["records"] if record in acts]
    texts = {"records": ", ".join(data["records"]), "aliases": ", ".join(data["aliases"])}
    return {
        **data,
        "frequencies_hz": {place["record"]: place["frequencies_hz"] for place in places},
        "places": places,
        "text": {**data["text"], **texts, "name": data["name"]},
    }


def _place(record: str, found: StrongestParts) -> dict[str, Any]:
    """Return the location of an effect in a record, with its description."""
    hz = [hertz(each) for each in found.frequencies_hz]
    text = " and ".join(filter(None, (", ".join(hz[:-1]), hz[-1]))) if hz else "-"
    kind = LINES if found.in_lines else BANDS
    return {"record": record, "frequencies_hz": list(found.frequencies_hz), "kind": kind, "text": text}


def _figure_names(pictures: FigureData) -> dict[str, Any]:
    """Return the names of figures by record."""
    stretch = pictures.stretch
    return {
        "spectra": [{"record": one.record, "figure": spectrum_name(one.record)} for one in pictures.spectra],
        "stretch": {"record": stretch.record, "figure": STRETCH_NAME} if stretch else None,
    }


def evidence_lines(found: Diagnosis) -> list[str]:
    """Return the verdict on the named effects in the terms of `mechid compare`, one line each."""
    if found.mechanism is None or not found.steps:
        return []
    fall = found.as_written.bic - found.steps[-1].bic
    level = next(word for limit, word in LEVELS if fall < limit or math.isinf(limit))
    by = (
        f"The Bayesian criterion prefers the mechanism with these effects {level}, by {digits(fall, 4)}: samples count "
    )
    lines = [f"{by}for what the residual's colour leaves of them, and each free number costs the logarithm of theirs."]
    lines += [
        f"Record {one.record}, held out: the residual is {digits(one.before, 4)} times its noise as written, "
        f"{digits(one.after, 4)} times with the effects."
        for one in found.held_out
    ]
    return [*lines, _outcome(found.held_out).value]


def _outcome(held_out: Sequence[HeldOut]) -> ComparisonOutcome:
    """Return the outcome of the prediction of held-out records, in relation to the criterion."""
    if not held_out:
        return ComparisonOutcome.UNTESTED
    before, after = (math.hypot(*values) for values in zip(*((h.before, h.after) for h in held_out), strict=True))
    # Negated, so that NaN counts as a failed prediction.
    if not after < math.inf or after > (1.0 + BETTER) * before:
        return ComparisonOutcome.DISPUTED
    return ComparisonOutcome.AGREED if after < (1.0 - BETTER) * before else ComparisonOutcome.UNDECIDED_BY_PREDICTION
