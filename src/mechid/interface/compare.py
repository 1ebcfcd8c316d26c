"""Finished fits side by side."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from mechid.analysis import validate
from mechid.analysis.comparison import Comparison
from mechid.analysis.comparison import compare as compare_folders
from mechid.errors import UsageError
from mechid.identification.result.fit import Fit
from mechid.interface.report import campaign_of
from mechid.reports.fit.numbers import report_data
from mechid.reports.fit.results import write_results


def compare(*fits: Fit | Path | str, names: tuple[str, ...] = ()) -> Comparison:
    """Compare finished fits of the same records.

    Parameters
    ----------
    *fits : Fit or Path
        Two or more: result folders or their estimate.json, or fits that hold their campaigns.
    names : tuple of str
        What they are called, one for each; none takes folders' names, ``fit_1``, ``fit_2`` for others.

    Returns
    -------
    Comparison
        Hypotheses, their scores, parameters side by side in the file's units, and the preference.

    Raises
    ------
    UsageError
        Fewer than two, one twice, fits of different records, or a fit that does not hold its campaign.
    InputFileError
        An estimate.json is missing, wrong, or without validation.

    Examples
    --------
    >>> import mechid
    >>> mechid.compare("fit_rigid", "fit_housing").preference.preferred  # doctest: +SKIP
    'fit_housing'
    """
    if names and len(names) != len(fits):
        raise UsageError(f"compare: {len(fits)} fits and {len(names)} names; give one for each, or none")
    with TemporaryDirectory(prefix="mechid_compare_") as aside:
        folders = [
            _folder(fit, Path(aside) / (names[k] if names else f"fit_{k + 1}"), named=bool(names))
            for k, fit in enumerate(fits)
        ]
        return compare_folders(*folders)


def _folder(fit: Fit | Path | str, aside: Path, *, named: bool) -> Path:
    """Return where a fit's estimate lies; one in memory, or to be called otherwise, is put aside."""
    if isinstance(fit, Fit):
        validation = validate(campaign_of(fit, None), fit)
        write_results(fit, report_data(fit, validation=validation), aside, validation=validation)
        return aside
    if named:
        raise UsageError("compare: names are of fits in memory; folders have their own")
    return Path(fit)
