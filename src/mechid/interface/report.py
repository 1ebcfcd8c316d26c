"""The files of a fit in a folder."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from mechid.analysis import validate
from mechid.campaign import Campaign
from mechid.errors import UsageError
from mechid.holding import held
from mechid.identification.result.fit import Fit
from mechid.reports.illustration import Illustration
from mechid.reports.pens import Pens
from mechid.reports.results import write_results
from mechid.reports.tables import report_data
from mechid.reports.writing import write_report


def report(
    fit: Fit,
    out: Path | str,
    *,
    campaign: Campaign | None = None,
    synthetic: bool = False,
    truth: Mapping[str, float] | None = None,
) -> list[Path]:
    """Write the results and the report of a fit into a folder: estimate.json, report.html, figures and all else.

    Parameters
    ----------
    fit : Fit
    out : Path
        Made with its parents where it is missing; earlier files of the names are replaced.
    campaign : Campaign or None
        Of which it was identified, its records read; None takes the one that the fit holds.
    synthetic : bool
        Whether the records were simulated, which every page then says.
    truth : mapping of str to float or None
        True values by dotted name, in the file's units; given, the records count as simulated.

    Returns
    -------
    list of Path
        The files, and the folder of the figures.

    Raises
    ------
    UsageError
        The folder cannot be written to, or the fit's campaign is not known.

    Examples
    --------
    >>> import mechid
    >>> mechid.report(mechid.load_fit("fit"), "again")  # doctest: +SKIP
    """
    own, folder, synthetic = campaign_of(fit, campaign), Path(out), synthetic or truth is not None
    with held(folder), Pens() as pens:
        illustration = Illustration(own, fit, folder, pens)
        validation = validate(own, fit, illustration.begin)
        data = report_data(fit, truth, synthetic=synthetic, validation=validation)
        files = write_results(fit, data, folder, validation=validation)
        files += write_report(data, own, fit, validation, folder, illustration)
    return list(dict.fromkeys(files))


def write_fit(fit: Fit, folder: Path) -> list[Path]:
    """Write what `report` writes of a fit that holds its campaign."""
    return report(fit, folder)


def campaign_of(fit: Fit, campaign: Campaign | None) -> Campaign:
    """Return the campaign given, else the one that a fit holds; UsageError where it holds none."""
    found = campaign or fit.campaign
    if found is None:
        raise UsageError("the fit does not hold its campaign; give campaign=, with its records read")
    return found
