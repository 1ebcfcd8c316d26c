"""Test report of an emission verdict: verification table, noise, records and deviations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from mechid.identification.result.estimate_file import DIGEST
from mechid.ink.data import Data
from mechid.ink.digits import digits, plain
from mechid.ink.document import Document, Part, Rows, Words
from mechid.ink.table import Table
from mechid.ink.text_table import Column
from mechid.specification.numbers import VERDICT_MEANING
from mechid.verification.declared import channel_table
from mechid.verification.report import VerificationReport, Verified, evidence_words
from mechid.verification.sections import report_document

TITLE = "Test report: emission at the interface"
TEST, ANALYSIS = "test", "analysis"
PREDICTED = "prediction of the fit, {}"
RUN = "run"
STATES = {"off": "motor unpowered", "holding": "motor powered, at rest", "empty": "table alone"}
METHOD = (
    "Method: test, evaluated from the records alone; analysis, predicted by a fit where its bound decides. Value: of "
    "the frequency and rate that decide. Margin: limit over value."
)
BACKGROUNDS = (
    Column("background", "name", words=True),
    Column("state", "state", words=True),
    Column("lasts, s", "duration"),
    Column("sample rate, Hz", "rate"),
)
LEVELS = (
    Column("direction", "direction", words=True),
    Column("background", "record", words=True),
    Column("RMS", "rms"),
    Column("unit", "unit", words=True),
)
NO_BACKGROUND = "No background was measured: the noise of the bench counts as emission."
LEVEL = "RMS of the background that is subtracted, over {} to {} Hz."


def emission_report(data: Mapping[str, Any], document: Document, files: Mapping[str, str]) -> Document:
    """Return the test report.

    Parameters
    ----------
    data : mapping
        As `emission_numbers` makes it.
    document : Document
        Of the verdict.
    files : mapping of str to str
        SHA-256 of the files of the result, by name.
    """
    runs = [_run(one) for one in data["sources"]]
    return report_document(
        VerificationReport(
            title=TITLE,
            document=document,
            verified=[_verification_row(one, runs, _digest(data)) for one in data["requirements"]],
            meaning=f"{VERDICT_MEANING} {METHOD}",
            test=data["test"],
            instruments=[Rows(channel_table(data["channels"]), "Channels of the records")],
            noise=list(_noise(data)),
            conditions=[Words(_conditions(data))],
            runs=runs,
            deviations=list(_deviations(data)),
            inputs=data["provenance"]["inputs_sha256"],
            versions=data["provenance"]["versions"],
            files=files,
        )
    )


def _run(source: Data) -> dict[str, Any]:
    state = source["state"]
    use = "run" if state == RUN else f"background, {STATES[state]}"
    return {**source, "file": Path(source["file"]).name, "use": use}


def _digest(data: Data) -> str:
    """Return the digest of the fitted mechanism that predicts; empty without one."""
    return str((data["prediction"] or {}).get(DIGEST) or "")


def _verification_row(one: Data, runs: list[dict[str, Any]], digest: str) -> Verified:
    worst, text, unit = one["worst"], one["text"], _unit(one)
    where = f" at {text['frequency']} Hz" if worst else ""
    where += f", {text['rate']} steps/s" if text["rate"] else ""
    source = next((run for run in runs if worst and run["name"] == worst["record"]), None)
    # Without a record the value that decides is a predicted one.
    predicted = one["predicted"] is not None and worst is not None and source is None
    evidence = f"{PREDICTED.format(worst['record'])}: {evidence_words('fitted mechanism', digest)}" if predicted else ""
    return Verified(
        requirement=f"{one['name']} ({one['direction']}, {one['kind'].replace('_', ' ')})",
        method=ANALYSIS if predicted else TEST,
        value=f"{text['value']} {unit}{where}" if worst else "none",
        limit=f"{text['limit']} {unit}" if worst else "",
        margin=f"{text['margin']} dB" if text["margin"] else "",
        verdict=text["verdict"],
        evidence=f"record {source['name']}: {evidence_words(source['file'], source['sha256'])}" if source else evidence,
    )


def _noise(data: Data) -> Iterator[Part]:
    backgrounds = [one for one in data["sources"] if one["state"] != RUN]
    if not backgrounds:
        yield Words(NO_BACKGROUND)
        return
    rows = [
        {
            "name": one["name"],
            "state": STATES[one["state"]],
            "duration": plain(one["duration_s"], 5),
            "rate": plain(one["sample_rate_hz"], 7),
        }
        for one in backgrounds
    ]
    yield Rows(Table(BACKGROUNDS, rows), "Background records")
    low, high = data["usable_band_Hz"]
    if data["backgrounds"] and low is not None and high is not None:
        yield Words(LEVEL.format(plain(low, 4), plain(high, 4)))
        levels = [{**one, "rms": digits(one["rms"], 3), "unit": _unit(one)} for one in data["backgrounds"]]
        yield Rows(Table(LEVELS, levels), "Level of the background")


def _unit(one: Data) -> str:
    """Return the unit of a requirement or a level in words."""
    return str(one["unit"]).replace("*", " ").replace("^2", "²")


def _conditions(data: Data) -> str:
    """Return the ranges of rates and sample rates at which was measured."""
    runs = [one for one in data["sources"] if one["state"] == RUN]
    rates = [abs(rate) for run in runs for rate in run["rates"] if rate is not None]
    stepped = f" at {_range(rates)} full steps/s" if rates else ""
    return f"{len(runs)} runs{stepped}, sampled at {_range([run['sample_rate_hz'] for run in runs])} Hz."


def _range(values: list[float]) -> str:
    low, high = min(values), max(values)
    return plain(low, 5) if low == high else f"{plain(low, 5)} to {plain(high, 5)}"


def _deviations(data: Data) -> Iterator[str]:
    if all(one["state"] == RUN for one in data["sources"]):
        yield NO_BACKGROUND
    for one in data["requirements"]:
        first, last = one["mask"][0][0], one["mask"][-1][0]
        mask, judged = f"its mask from {plain(first, 5)} to {plain(last, 5)} Hz", one["judged_Hz"]
        if not one["at_rates"] or judged is None:
            yield f"{one['name']}: not judged; no record has its rates, or its frequencies."
        elif judged[0] > first or judged[1] < last:
            yield f"{one['name']}: {mask} is judged from {plain(judged[0], 5)} to {plain(judged[1], 5)} Hz alone."
        if one["verdict"] != "pass":
            yield f"{one['name']}: {one['text']['verdict']}."
