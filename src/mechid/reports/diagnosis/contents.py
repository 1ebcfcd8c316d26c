"""All that a diagnosis shows: its numbers, and their texts, in one plain dict."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from mechid.identification.diagnosis.diagnosis import Diagnosis
from mechid.identification.diagnosis.pictures import Pictures
from mechid.identification.result.diagnosis_file import FORMAT
from mechid.reports.diagnosis.evidence import evidence_lines
from mechid.reports.diagnosis.figures import STRETCH_NAME, hertz, spectrum_name
from mechid.reports.fit.lacking import missing_data
from mechid.reports.fit.path import path_rows
from mechid.signal.strongest import Strongest

LINES, BANDS = "lines", "third octaves around"


def diagnosis_data(found: Diagnosis) -> dict[str, Any]:
    """Return all that a diagnosis shows: numbers, and beside those that need rounding their text."""
    return {
        "format": FORMAT,
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
        "drawn": _drawn(found.pictures),
    }


def _entry(data: dict[str, Any], pictures: Pictures) -> dict[str, Any]:
    acts = pictures.acts.get(data["name"], {})
    places = [_place(record, acts[record]) for record in data["records"] if record in acts]
    texts = {"records": ", ".join(data["records"]), "aliases": ", ".join(data["aliases"])}
    return {
        **data,
        "frequencies_hz": {place["record"]: place["frequencies_hz"] for place in places},
        "places": places,
        "text": {**data["text"], **texts, "name": data["name"]},
    }


def _place(record: str, found: Strongest) -> dict[str, Any]:
    """Return where in a record an effect acts, with the words for it."""
    hz = [hertz(each) for each in found.frequencies_hz]
    text = " and ".join(filter(None, (", ".join(hz[:-1]), hz[-1]))) if hz else "-"
    kind = LINES if found.in_lines else BANDS
    return {"record": record, "frequencies_hz": list(found.frequencies_hz), "kind": kind, "text": text}


def _drawn(pictures: Pictures) -> dict[str, Any]:
    """Return of which records there are figures, with their names."""
    stretch = pictures.stretch
    return {
        "spectra": [{"record": one.record, "figure": spectrum_name(one.record)} for one in pictures.spectra],
        "stretch": {"record": stretch.record, "figure": STRETCH_NAME} if stretch else None,
    }
