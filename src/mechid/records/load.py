"""Public function that reads a measured file by itself."""

from __future__ import annotations

from pathlib import Path

from mechid.records.bare import Hints, read_bare
from mechid.records.record import Record


def load_record(
    path: Path | str,
    *,
    sample_rate_hz: float | None = None,
    columns: tuple[str, ...] = (),
    quantity: str | None = None,
    unit: str | None = None,
) -> tuple[Record, ...]:
    """Read all channels of a measured file: one record for those that are sampled together.

    Parameters
    ----------
    path : Path
        Text, .mat, .h5, .nc, .tdms, .uff, .parquet, .npy or .npz; docs/records.md.
    sample_rate_hz : float or None
        Of a file without a time column or clock.
    columns : tuple of str
        Those to read, by name or by index from 0; none takes all.
    quantity, unit : str or None
        What they are, and the unit of their numbers where the file states none.

    Returns
    -------
    tuple of Record
        Channels in SI units; one without a unit in its own numbers.

    Raises
    ------
    RecordError
        The file is missing, is no record, or holds no channel that can be read.
    UsageError
        The quantity is unknown.

    Examples
    --------
    >>> import mechid
    >>> (record,) = mechid.load_record("full_46.csv")  # doctest: +SKIP
    >>> record.to_pandas()  # doctest: +SKIP
    """
    return read_bare(Path(path), Hints(sample_rate_hz=sample_rate_hz, columns=columns, quantity=quantity, unit=unit))
