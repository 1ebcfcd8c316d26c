"""Check that a folder holds the finished fit of an unchanged campaign, by digests of all inputs of the fit."""

from __future__ import annotations

from pathlib import Path

from mechid.campaign import Campaign
from mechid.errors import InputFileError
from mechid.identification.computation.journal import VERSION, last_run, with_version
from mechid.identification.output_error.digests import file_digests
from mechid.identification.result.fit_file import read_numbers
from mechid.identification.result.grade import FitOutcome
from mechid.identification.result.journal_file import FILE_NAME as JOURNAL_NAME
from mechid.identification.result.journal_file import FINISHED
from mechid.reports.into_folder import identification_inputs

COMPLETE, SEED = "--complete", "seed"


def changed_inputs(campaign: Campaign, folder: Path, seed: int, *, complete: bool) -> tuple[str, ...] | None:
    """Return the inputs that have changed since a campaign was identified into a folder; None without a finished fit.

    Inputs are files by their names, and other inputs named by the journal, such as a table that a record's command
    reads. The version of mechid is ignored.
    """
    try:
        fit = read_numbers(folder)
    except InputFileError:
        return None
    known, events = last_run(folder / JOURNAL_NAME)
    is_completed = fit.completed is not None
    # An interrupted run leaves its best result so far, which must not pass for a finished fit.
    if FINISHED not in events or fit.outcome is FitOutcome.INTERRUPTED:
        return None
    files, inputs = file_digests(campaign), identification_inputs(campaign, seed)
    if is_completed:
        # The estimate refers to the completed mechanism file; the journal has the digest of the campaign's own.
        del files[campaign.mechanism_path.name]
    changed = [name for name, digest in files.items() if fit.inputs_sha256.get(name) != digest]
    changed += [name for name in sorted({*inputs, *known} - {VERSION}) if inputs.get(name) != known.get(name)]
    changed += [SEED] if fit.provenance.get("seed") != seed and SEED not in changed else []
    changed += [] if is_completed == complete else [COMPLETE]
    return tuple(changed)


def can_resume(campaign: Campaign, folder: Path, seed: int) -> bool:
    """Return whether the last run in a folder's journal was of the same campaign, by this version of mechid."""
    inputs, _ = last_run(folder / JOURNAL_NAME)
    return inputs == with_version(identification_inputs(campaign, seed))
