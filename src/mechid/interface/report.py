"""The files of a fit in a folder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from mechid.analysis import validate
from mechid.campaign import Campaign
from mechid.holding import held
from mechid.identification.result.estimate_file import read_estimate, signed
from mechid.identification.result.fit import ESTIMATE_NAME, Fit
from mechid.ink.pens import Pens
from mechid.reports.fit.files import write_report
from mechid.reports.fit.illustration import Illustration
from mechid.reports.fit.numbers import report_data
from mechid.reports.fit.results import estimated_text, read_truth, write_components, write_residual, write_results
from mechid.reports.identified import mechanism_name


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
        Made with its parents where it is missing; earlier files of the names are replaced. Where it holds the results
        of this very fit, as one of `load_fit`, these stay and the report alone is made anew.
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
    own, folder = campaign or fit.required_campaign, Path(out)
    with held(folder), Pens() as pens, Illustration(own, fit, folder, pens) as illustration:
        again = _is_there(fit, folder)
        was, known = read_truth(folder) if again and truth is None else (False, truth)
        fit = replace(fit, synthetic=fit.synthetic or synthetic or was or truth is not None)
        validation = validate(own, fit, illustration.begin)
        name = mechanism_name(own, folder)
        fit = fit if again else signed(fit, name, estimated_text(fit))
        data = report_data(fit, known, validation=validation)
        files = [] if again else write_results(fit, data, folder, mechanism_name=name, validation=validation)
        files += write_report(data, own, fit, validation, folder, illustration)
        if again:
            files += [write_residual(fit, validation, folder), *write_components(fit, validation, folder)]
    return list(dict.fromkeys(files))


def _is_there(fit: Fit, folder: Path) -> bool:
    """Tell whether a folder holds the results of this very fit, whose files are signed by one another."""
    path = folder / ESTIMATE_NAME
    return path.is_file() and read_estimate(path).get("provenance") == fit.provenance


def write_fit(fit: Fit, folder: Path) -> list[Path]:
    """Write what `report` writes of a fit that holds its campaign."""
    return report(fit, folder)
