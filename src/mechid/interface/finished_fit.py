"""What ``mechid profile``, ``mechid bootstrap`` and ``mechid diagnose`` begin from: a finished fit and its campaign."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mechid.campaign import Campaign, load_campaign
from mechid.campaign.campaign_file import FILE_NAME as CAMPAIGN_NAME
from mechid.errors import InputFileError
from mechid.identification.computation.journal import digest
from mechid.identification.output_error.identity import campaign_digests
from mechid.identification.result.estimate_file import FILE_NAME, WITH_ERRORS, read_estimate
from mechid.identification.result.journal_file import identified_campaign
from mechid.reports.identified import COMPLETED_NAME


@dataclass(frozen=True)
class FinishedFit:
    """A campaign and what estimate.json says of it."""

    campaign: Campaign
    estimate: dict[str, Any]

    @property
    def inputs(self) -> dict[str, str]:
        """Digests of what follows from here, for a journal."""
        values = [[name, p["value"], p["status"]] for name, p in self.estimate["parameters"].items()]
        return {**campaign_digests(self.campaign), "estimate.json": digest(values)}


def finished_fit(source: Path, campaign: Path | None) -> FinishedFit:
    """Return the fit of a result folder, or the one that lies beside a campaign file.

    The campaign is the one given, or lies in the folder, or is named by the journal of the identification.

    Raises
    ------
    InputFileError
        There is no such folder, no estimate.json in it, or the campaign cannot be found.
    """
    if not source.exists():
        raise InputFileError(f"{source}: there is no such folder or file; give the result folder of mechid identify")
    folder = source if source.is_dir() else source.parent
    estimate = read_estimate(folder / FILE_NAME, needs=(*WITH_ERRORS, "records", "provenance"))
    beside = source if source.is_file() else folder / CAMPAIGN_NAME
    path = campaign or (beside if beside.is_file() else identified_campaign(folder))
    return FinishedFit(load_campaign(path, mechanism_file=completed_file(folder, estimate)), estimate)


def completed_file(folder: Path, estimate: Mapping[str, Any] | None = None) -> Path | None:
    """Return the mechanism file of a result folder that identify has completed; None where it is the campaign's."""
    found = read_estimate(folder / FILE_NAME) if estimate is None else estimate
    return folder / COMPLETED_NAME if found.get("completed") is not None else None
