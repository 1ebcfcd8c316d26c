"""What ``mechid profile`` and ``mechid bootstrap`` begin from: a finished fit and its campaign."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mechid.campaign import Campaign, load_campaign
from mechid.campaign.campaign_file import FILE_NAME as CAMPAIGN_NAME
from mechid.cli.journal import FILE_NAME as JOURNAL_NAME
from mechid.errors import UsageError
from mechid.identification.estimate_file import FILE_NAME, read_estimate
from mechid.identification.inputs import campaign_digests
from mechid.identification.journal import digest


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
        There is no estimate.json.
    UsageError
        The campaign cannot be found.
    """
    folder = source if source.is_dir() else source.parent
    estimate = read_estimate(folder / FILE_NAME)
    beside = source if source.is_file() else folder / CAMPAIGN_NAME
    path = campaign or (beside if beside.is_file() else _noted(folder / JOURNAL_NAME))
    if path is None:
        raise UsageError(f"{folder}: does not say which campaign it is of; give it with --campaign")
    return FinishedFit(load_campaign(path), estimate)


def _noted(journal: Path) -> Path | None:
    """Return the campaign of the last run in a journal."""
    found = None
    for line in journal.read_text(encoding="utf-8").splitlines() if journal.is_file() else []:
        if '"event": "started"' in line:
            found = json.loads(line).get("campaign")
    return Path(found) if found else None
