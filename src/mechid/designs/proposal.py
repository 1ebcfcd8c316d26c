"""Proposal of a design as files: a campaign ready to be driven, and the design file that produced it."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from mechid.campaign.campaign_writer import command_text
from mechid.campaign.mechanism_text import mechanism_text
from mechid.campaign.templates import MECHANISM_NAME, RecordDraft, campaign_text
from mechid.campaign.toml_file import toml_number, toml_text
from mechid.designs.design import Design
from mechid.designs.planned_record import PlannedRecord
from mechid.errors import UsageError
from mechid.writing import write_together

CAMPAIGN_NAME, OPTIONS_NAME = "campaign.toml", "design.toml"
GUIDE = """\
Proposed by mechid design. Drive each record as its command says, from rest, and put the measured file in its place:
one header line, time_s,torque_Nm. {records}, {seconds:.0f} s with {between:g} s between them; {chosen_by}.
Lengths and noise stand in design.toml beside this file: mechid design on this folder takes them from there."""


def write_proposal(design: Design, data: Mapping[str, Any], folder: Path) -> list[Path]:
    """Write campaign and design file of the chosen records, and the mechanism if no file holds it.

    Raises
    ------
    UsageError
        The folder cannot be written to, or holds the campaign itself.
    """
    refuse_own_folder(design.campaign.path, folder)
    texts = {CAMPAIGN_NAME: proposed_campaign(design, data, folder), OPTIONS_NAME: proposed_options(design)}
    if not has_file(design):
        texts[MECHANISM_NAME] = mechanism_text(design.campaign.mechanism)
    return write_together(folder, texts)


def refuse_own_folder(campaign: Path, folder: Path) -> None:
    """Raise UsageError if the proposal would replace the campaign file from which it is made."""
    if folder.resolve() == campaign.parent.resolve():
        raise UsageError(f"{folder}: holds the campaign itself, which must not be replaced; give another folder")


def proposed_campaign(design: Design, data: Mapping[str, Any], folder: Path) -> str:
    """Return campaign.toml of the chosen records, with comments; it refers to a mechanism file."""
    peaks = {r["name"]: r["peak_torque_Nm"] for r in data["candidates"]}
    file = design.campaign.mechanism_path if has_file(design) else folder / MECHANISM_NAME
    mechanism = Path(os.path.relpath(file.absolute(), folder.absolute())).as_posix()
    count = len(design.chosen.records)
    guide = GUIDE.format(
        records=f"{count} record{'s' * (count != 1)}",
        seconds=design.chosen.seconds,
        between=design.options.limits.between_s,
        chosen_by=f"chosen by {criterion_words(data)}",
    )
    drafts = [
        RecordDraft(name=r.name, file=f"{r.name}.csv", command=command_text(r.command) + _remark(r, data, peaks))
        for r in design.chosen.records
    ]
    return campaign_text(drafts, guide, mechanism=mechanism)


def has_file(design: Design) -> bool:
    """Return whether the mechanism has a file; one made in code has none."""
    return design.campaign.mechanism_path.is_file()


def criterion_words(data: Mapping[str, Any]) -> str:
    """Return the criterion in words."""
    kind = data["criterion"]["kind"]
    return f"the standard error of {kind}" if data["criterion"]["is_parameter"] else f"the {kind}-criterion"


def _remark(record: PlannedRecord, data: Mapping[str, Any], peaks: Mapping[str, float]) -> str:
    """Return a comment with duration and expected torque."""
    remark = f"  # {record.duration_s:g} s"
    if record.name in peaks:
        remark += f", peak {peaks[record.name]:.2g} N m expected"
    found = data["margins"].get(record.name)
    if found and found["voltage"] is not None:
        remark += f", steps are lost below {100.0 * (1.0 - found['voltage']):.0f} % of the voltage"
    for group in data["rivals"] or ():
        if record.name in group["records"]:
            remark += f"; is to tell {' from '.join(group['names'])}"
    return remark


def proposed_options(design: Design) -> str:
    """Return design.toml of a design, with the settings needed to design the proposed campaign again."""
    return "\n".join(_option_lines(design)) + "\n"


def _option_lines(design: Design) -> Iterator[str]:
    limits = design.options.limits
    first = design.candidates[0]
    yield "# Of the campaign beside this file, for mechid design."
    yield "[recording]"
    yield f"noise_Nm = {toml_number(first.sigma)}"
    yield f"sample_rate_hz = {toml_number(first.sample_rate_hz)}"
    pairs = ", ".join(f"{r.name} = {toml_number(r.duration_s)}" for r in design.chosen.records)
    yield f"durations_s = {{ {pairs} }}"
    yield "[limits]"
    yield f"total_s = {toml_number(design.total_s)}"
    yield f"between_s = {toml_number(limits.between_s)}"
    if limits.torque_Nm:
        yield f"torque_Nm = {toml_number(limits.torque_Nm)}"
    yield "[criterion]"
    yield f"kind = {toml_text(design.options.criterion)}"
