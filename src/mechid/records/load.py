"""Public function for reading a measured file without a campaign."""

from __future__ import annotations

from pathlib import Path

from mechid.records.record import Record
from mechid.records.undeclared import Hints, read_bare


def load_record(
    path: Path | str,
    *,
    sample_rate_hz: float | None = None,
    columns: tuple[str, ...] = (),
    quantity: str | None = None,
    unit: str | None = None,
) -> tuple[Record, ...]:
    """Read all channels of a measured file into one record per common clock.

    Parameters
    ----------
    path : Path
        Text, .mat, .h5, .nc, .tdms, .uff, .parquet, .npy or .npz; see docs/records.md.
    sample_rate_hz : float or None
        Sample rate of a file without a time column or clock.
    columns : tuple of str
        Columns to read, by name or by index from 0; empty for all.
    quantity, unit : str or None
        Quantity of the columns, and their unit if the file states none.

    Returns
    -------
    tuple of Record
        Channels in SI units; channels without a unit keep the numbers of the file.

    Raises
    ------
    RecordError
        The file is missing, is not a record, or has no readable channel.
    UsageError
        The quantity is unknown.

    Examples
    --------
    >>> import mechid
    >>> (record,) = mechid.load_record("full_46.csv")  # doctest: +SKIP
    >>> record.to_pandas()  # doctest: +SKIP
    """
    return read_bare(Path(path), Hints(sample_rate_hz=sample_rate_hz, columns=columns, quantity=quantity, unit=unit))
