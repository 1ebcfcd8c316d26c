"""Records before any model."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from mechid.analysis.survey import Survey, survey
from mechid.campaign import Campaign, load_campaign
from mechid.campaign.in_code import RecordEntry
from mechid.identification.identifiability.visibility import start_warnings
from mechid.identification.stages.first_seen import declaration_warnings
from mechid.records.bare import Hints
from mechid.shown import Shown


def look(
    *records: Path | str | Campaign | RecordEntry,
    sample_rate_hz: float | None = None,
    columns: Sequence[str] = (),
    quantity: str | None = None,
    unit: str | None = None,
) -> Survey:
    """Look at records before any model: health, noise, lines, resonances, and how they seem to be driven.

    Parameters
    ----------
    *records : Path, Campaign or RecordEntry
        Measured files, campaign files or their folders; campaigns whose records are read, and records of
        `make_record`, with their commands.
    sample_rate_hz : float or None
        Of files without a time column or clock.
    columns : sequence of str
        Of the files, by name or by index from 0; none takes all.
    quantity, unit : str or None
        What these columns are, and the unit of their numbers where the file states none.

    Returns
    -------
    Survey
        `left_out` names the files that could not be read.

    Raises
    ------
    InputFileError
        A campaign file is wrong.
    RecordError
        No record can be read.
    UsageError
        The quantity is unknown.

    Examples
    --------
    >>> import mechid, numpy as np
    >>> hum = 0.01 * np.sin(2.0 * np.pi * 50.0 * np.arange(20_000) / 10_000.0)
    >>> noisy = hum + 0.001 * np.random.default_rng(0).standard_normal(hum.size)
    >>> seen = mechid.look(mechid.make_record("quiet", noisy, sample_rate_hz=10_000.0))
    >>> round(seen.looks[0].channels[0].mains[0].line.frequency_hz)
    50
    """
    hints = Hints(sample_rate_hz=sample_rate_hz, columns=tuple(columns), quantity=quantity, unit=unit)
    return survey([Path(one) if isinstance(one, str) else one for one in records], hints)


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
