"""Test report of a fit: verification table of the residuals, noise, records and deviations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from mechid.analysis.noise_floor_test import NoiseLevel
from mechid.campaign import Campaign
from mechid.identification.result.fit import ESTIMATE_NAME
from mechid.ink.data import Data
from mechid.ink.digits import plain
from mechid.ink.document import Document, Part, Rows, Words
from mechid.ink.quantities import has_only_torque, quantity_words
from mechid.ink.table import Table
from mechid.ink.text_table import Column
from mechid.parameter import Status
from mechid.reports.noise import compare_with_noise
from mechid.reports.use import held_out, left_out
from mechid.verification.declared import channel_table
from mechid.verification.report import VerificationReport, Verified, evidence_words
from mechid.verification.sections import report_document

TITLE = "Test report: identification of {}"
TEST, COMPARED = "test", "test, compared with simulation"
MET, NOT_MET, NOT_TESTED = "met", "not met", "not tested"
MEANING = (
    "mechid asks this of every identification. A residual is met where it is no larger than chance makes of the noise "
    "of its record; its limit and its margin are relative to that noise. A parameter is met where the records tell it."
)
GRADES = ("A", "B")
NOISE = (
    Column("record", "name", words=True),
    Column("channel", "quantity", words=True),
    Column("noise, RMS", "noise"),
    Column("unit", "unit", words=True),
    Column("level rests on", "basis", words=True),
)
NOISE_SAID = "Noise of each record as it was known before the fit, and the basis of that level."
NO_HELD_OUT = "No record was held out of the fit: the prediction of new records is not tested."


def fit_report(
    contents: Mapping[str, Any], campaign: Campaign, document: Document, files: Mapping[str, str]
) -> Document:
    """Return the test report.

    Parameters
    ----------
    contents : mapping
        As `report_contents` makes it.
    campaign : Campaign
        Its records read.
    document : Document
        Of the fit.
    files : mapping of str to str
        SHA-256 of the files of the result, by name.
    """
    provenance = contents["provenance"]
    return report_document(
        VerificationReport(
            title=TITLE.format(contents["title"]),
            document=document,
            verified=list(_verification_rows(contents, evidence_words(ESTIMATE_NAME, files.get(ESTIMATE_NAME, "")))),
            meaning=MEANING,
            # Of the campaign as it is: statements on the test may be completed after the identification.
            test=campaign.test.to_dict(),
            instruments=[Rows(channel_table(_channels(campaign)), "Channels of the records")],
            noise=[Words(NOISE_SAID), Rows(noise_table(contents), "Noise of the records")],
            conditions=list(_conditions(contents)),
            runs=_runs(contents, campaign),
            deviations=list(_deviations(contents)),
            inputs=provenance.get("inputs_sha256", {}),
            versions=provenance.get("versions", {}),
            files=files,
        )
    )


def _verification_rows(contents: Data, estimate: str) -> Iterator[Verified]:
    grade = contents["grade"]
    yield Verified(
        requirement="the fit may be relied on",
        method=TEST,
        value=f"grade {grade}",
        limit=f"grade {' or '.join(GRADES)}",
        verdict=MET if grade in GRADES else NOT_MET,
        evidence=estimate,
    )
    free = [row for row in contents["parameters"] if row["estimated"] and row["status"] != Status.TIED]
    told = [row for row in free if row["std_error"]]
    yield Verified(
        requirement="free parameters are identified",
        method=TEST,
        value=f"{len(told)} of {len(free)}",
        limit=f"{len(free)} of {len(free)}",
        verdict=MET if len(told) == len(free) else NOT_MET,
        evidence=estimate,
    )
    yield from (_residual_row(contents, row) for row in contents["validation"])
    if not held_out(contents["validation"]):
        yield Verified(requirement="prediction of new records", method=COMPARED, value="none", verdict=NOT_TESTED)


def _residual_row(contents: Data, row: Data) -> Verified:
    """Return the row of a channel's residual against the noise of its record."""
    residual, source = compare_with_noise(contents, row), contents["provenance"].get("records", {}).get(row["name"], {})
    channel = "" if row["quantity"] == "torque" else f", {quantity_words(row['quantity'])}"
    use = "predicted, held out of the fit," if row["use"] == "validate" else "explained"
    use = "left out of the fit, predicted" if row["left_out"] else use
    known = residual.level is not NoiseLevel.LOST
    limit = residual.most_by_chance
    good = residual.level in (NoiseLevel.NOISE, NoiseLevel.COLOURED)
    return Verified(
        requirement=f"{row['name']}{channel}: {use} down to the noise",
        method=COMPARED,
        value=f"{residual.ratio:.3g} times the noise" if known else "simulation fails",
        limit=f"{limit:.3g} times the noise",
        margin=f"{100.0 * (1.0 - residual.ratio / limit):+.2g} %" if known else "",
        verdict=MET if good else NOT_MET,
        evidence=evidence_words(str(source.get("file", "")), str(source.get("sha256", ""))),
    )


def noise_table(contents: Data) -> Table:
    """Return the noise level of each channel of each record."""
    alone = has_only_torque(contents["channels"])
    rows = contents["records"] if alone or not contents["channels"] else contents["channels"]
    return Table(
        NOISE,
        [
            {
                "name": row["name"],
                "quantity": quantity_words(row.get("quantity", "torque")),
                "noise": row["text"]["noise_known"],
                "unit": row.get("unit", "N m"),
                "basis": row["noise_rests_on"],
            }
            for row in rows
        ],
    )


def _channels(campaign: Campaign) -> list[dict[str, Any]]:
    """Return the channels as declared, each once, with the records that have it."""
    named: dict[Any, list[str]] = {}
    for record in campaign.records:
        for channel in record.spec.channels:
            named.setdefault(channel, []).append(record.name)
    return [{**channel.to_dict(), "records": names} for channel, names in named.items()]


def _runs(contents: Data, campaign: Campaign) -> list[dict[str, Any]]:
    records, driven = contents["provenance"].get("records", {}), contents["driven"]
    return [
        {
            "name": record.name,
            "use": driven[record.name]["use"],
            "command": driven[record.name]["command"],
            "file": records.get(record.name, {}).get("file") or record.data.path.name,
            "sha256": records.get(record.name, {}).get("sha256") or record.data.digest,
            "started": record.data.start_time,
            "duration_s": record.data.duration_s,
            "sample_rate_hz": record.data.sample_rate_hz,
        }
        for record in campaign.records
        if record.data is not None and record.name in driven
    ]


def _conditions(contents: Data) -> Iterator[Part]:
    driven = contents["driven"].values()
    seconds = sum(one["duration_s"] for one in driven)
    yield Words(f"{len(driven)} records, {plain(seconds, 5)} s in all; how each was driven stands in their table.")


def _deviations(contents: Data) -> Iterator[str]:
    for name, one in contents["driven"].items():
        if one["taken"]:
            taken = ", ".join(f"{key} {value}" for key, value in one["taken"].items())
            yield f"{name}: not as declared: {taken}."
    for row in left_out(contents["validation"]):
        yield f"{row['name']}: left out of the fit, since it contradicts the other records."
    for one in contents["missing"]:
        yield f"{one['words']} ({one['name']}): not declared in the files, and added because the records need it."
    if not held_out(contents["validation"]):
        yield NO_HELD_OUT
    yield from contents["warnings"]
