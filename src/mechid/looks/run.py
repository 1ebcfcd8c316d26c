"""Public function for surveying records before any model."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from mechid.analysis.survey import Survey, survey
from mechid.campaign import Campaign
from mechid.campaign.campaign_in_code import RecordEntry
from mechid.records.undeclared import Hints


def look(
    *records: Path | str | Campaign | RecordEntry,
    sample_rate_hz: float | None = None,
    columns: Sequence[str] = (),
    quantity: str | None = None,
    unit: str | None = None,
) -> Survey:
    """Survey records before any model: health, noise, lines, resonances, and the drive that they suggest.

    Parameters
    ----------
    *records : Path, Campaign or RecordEntry
        Measured files, campaign files or their folders; campaigns whose records are read, and records of
        `make_record`, with their commands.
    sample_rate_hz : float or None
        Sample rate of files without a time column or clock.
    columns : sequence of str
        Columns of the files, by name or by index from 0; empty takes all.
    quantity, unit : str or None
        Quantity of these columns, and the unit of their numbers if the file states none.

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
