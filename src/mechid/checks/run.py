"""Public function that says what was understood of a campaign."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from mechid.campaign import Campaign, load_campaign
from mechid.identification.readings.detectors import declaration_warnings
from mechid.identification.uncertainty.visibility import start_warnings
from mechid.shown import Shown


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Understanding(Shown):
    """What was understood of a campaign.

    Attributes
    ----------
    campaign : Campaign
    found : tuple of str
        Warnings beside the campaign's own: what its records contradict, what they cannot show.
    """

    campaign: Campaign
    found: tuple[str, ...]

    @property
    def warnings(self) -> tuple[str, ...]:
        """All that is odd and yet usable, one line each."""
        return (*self.campaign.warnings, *self.found)


def check(campaign: Campaign | Path | str) -> Understanding:
    """Say what was understood of a campaign, and what is odd about it.

    Parameters
    ----------
    campaign : Campaign or Path
        A campaign file or its folder is read; its records need no files.

    Returns
    -------
    Understanding
        Its `write` leaves a picture of each record with its command.

    Raises
    ------
    InputFileError
        The campaign or mechanism file is missing or wrong.
    RecordError
        A record's file is missing or cannot be used.

    Examples
    --------
    >>> import mechid
    >>> mechid.check("bench").warnings  # doctest: +SKIP
    ()
    """
    loaded = campaign if isinstance(campaign, Campaign) else load_campaign(campaign, need_files=False)
    found: Iterable[str] = (*declaration_warnings(loaded), *start_warnings(loaded))
    return Understanding(campaign=loaded, found=tuple(found))
