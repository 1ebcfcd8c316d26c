"""Public function that checks a campaign."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from mechid.campaign import Campaign, load_campaign
from mechid.display import DisplayedResult
from mechid.identification.readings.detectors import declaration_warnings
from mechid.identification.uncertainty.visibility import chopper_objection, start_warnings


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Understanding(DisplayedResult):
    """Result of a check: the campaign as interpreted, with warnings.

    Attributes
    ----------
    campaign : Campaign
    found : tuple of str
        Warnings in addition to those of the campaign, on contradictory declarations and undeterminable starts.
    """

    campaign: Campaign
    found: tuple[str, ...]

    @property
    def warnings(self) -> tuple[str, ...]:
        """One line for each suspicious but usable input."""
        return (*self.campaign.warnings, *self.found)


def check(campaign: Campaign | Path | str) -> Understanding:
    """Check a campaign: show its interpretation and warn of suspicious inputs.

    Parameters
    ----------
    campaign : Campaign or Path
        Campaign, or its file or folder; records need no files.

    Returns
    -------
    Understanding
        Its `write` saves a figure of each record with its command.

    Raises
    ------
    InputFileError
        The campaign or mechanism file is missing or invalid.
    RecordError
        A record's file is missing or unusable.

    Examples
    --------
    >>> import mechid
    >>> mechid.check("bench").warnings  # doctest: +SKIP
    ()
    """
    loaded = campaign if isinstance(campaign, Campaign) else load_campaign(campaign, need_files=False)
    if objection := chopper_objection(loaded) if loaded.mechanism.free else "":
        return Understanding(campaign=loaded, found=(objection,))
    # Planned records are accepted, so that a campaign can be checked before the test.
    found: Iterable[str] = (*declaration_warnings(loaded), *start_warnings(loaded))
    return Understanding(campaign=loaded, found=tuple(found))
