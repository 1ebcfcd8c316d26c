"""Public function that compares finished fits."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from mechid.analysis.comparison import Comparison
from mechid.analysis.comparison import compare as compare_fits
from mechid.analysis.hypothesis import short_names
from mechid.errors import UsageError

if TYPE_CHECKING:
    from mechid.identification.result.fit import Fit

IN_MEMORY = "in memory"
"""Placeholder for the folder of a fit in memory."""


def compare(*fits: Fit | Path | str, names: tuple[str, ...] = ()) -> Comparison:
    """Compare finished fits of the same records.

    Parameters
    ----------
    *fits : Fit or Path
        Two or more: result folders or their estimate.json, or fits that hold their campaigns.
    names : tuple of str
        Names of the fits; by default those of the folders, or ``fit_1``, ``fit_2`` for fits in memory.

    Returns
    -------
    Comparison
        Hypotheses with scores, parameters in the units of the file, and the preference.

    Raises
    ------
    UsageError
        There are fewer than two fits, one is given twice, their records differ, or a fit in memory lacks its campaign.
    InputFileError
        An estimate.json is missing or invalid, or has no validation.

    Examples
    --------
    >>> import mechid
    >>> mechid.compare("fit_rigid", "fit_housing").preference.preferred  # doctest: +SKIP
    'fit_housing'
    """
    if len(fits) < 2:
        raise UsageError(f"compare: found {len(fits)} folder; give two or more result folders of mechid identify")
    if names and len(names) != len(fits):
        raise UsageError(f"compare: {len(fits)} fits and {len(names)} names; give one for each, or none")
    if names and any(isinstance(fit, Path | str) for fit in fits):
        raise UsageError("compare: names are of fits in memory; folders have their own")
    places = [_folder(fit, names[k] if names else f"fit_{k + 1}") for k, fit in enumerate(fits)]
    twice = [place for k, place in enumerate(places) if place.resolve() in {p.resolve() for p in places[:k]}]
    if twice:
        raise UsageError(f"{twice[0].name if names else twice[0]}: given twice; give each result folder once")
    read = [_read(fit) if isinstance(fit, Path | str) else fit for fit in fits]
    return compare_fits(dict(zip(names or short_names(places), read, strict=True)))


def _folder(fit: Fit | Path | str, name: str) -> Path:
    """Return the folder of a fit; for a fit in memory, its name instead."""
    if not isinstance(fit, Path | str):
        return Path(IN_MEMORY, name)
    return Path(fit).parent if Path(fit).suffix == ".json" else Path(fit)


def _read(place: Path | str) -> Fit:
    # Imported here: it loads the campaign package, which fits in memory have loaded already.
    from mechid.identification.result.fit_file import read_numbers

    return read_numbers(place)
