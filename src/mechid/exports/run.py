"""Public function that writes a finished fit as files that others use without mechid."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

from mechid.campaign import Campaign, load_campaign
from mechid.exports.export import Exported, exported
from mechid.exports.handover import handover
from mechid.identification.result.fit import Fit


def export(
    fit: Fit | Path | str,
    *,
    to: str,
    out: Path | str,
    campaign: Campaign | Path | str | None = None,
    anyway: bool = False,
    folder: Path | str | None = None,
    options: object = None,
) -> Exported:
    """Write a finished fit for others: C text, FMUs, a linear model, tables.

    Parameters
    ----------
    fit : Fit or Path
        A fit, or the result folder of one, or the campaign file beside which the results lie.
    to : {"c", "fmu", "linear", "tables"}
    out : Path
        Folder for the files; made where missing.
    campaign : Campaign, Path or None
        Of which it was identified: its commands are those under which what is written is compared with mechid. None
        takes the one that the fit holds, or that the folder names.
    anyway : bool
        Whether a fit that failed is written too.
    folder : Path or None
        Where identify left a fit in memory; what its records have left beside the model is read from there.
    options : the target's `Options`, mapping of str to str, or None
        As ``mechid.exports.tables.options.Options(rates=(23.0, 46.0))``; None takes the defaults.

    Raises
    ------
    UsageError
        There is no such target, it cannot express the mechanism, or the folder cannot be written to.
    InputFileError
        The folder holds no fit, or what it holds is damaged; or the campaign cannot be found.
    FitError
        The fit has failed.

    Examples
    --------
    >>> import mechid
    >>> mechid.export("fit", to="tables", out="tables").written.files  # doctest: +SKIP
    """
    if isinstance(fit, Fit):
        source = fit if folder is None else replace(fit, folder=Path(folder))
        own = load_campaign(campaign) if isinstance(campaign, Path | str) else campaign or fit.campaign
    else:
        source, own, notice = read_with_campaign(Path(fit), campaign)
        if notice:
            warnings.warn(notice, stacklevel=2)
    return exported(handover(source, own, anyway=anyway), to, Path(out), options)


def read_with_campaign(source: Path, campaign: Campaign | Path | str | None = None) -> tuple[Fit, Campaign, str]:
    """Return the fit of a result folder, its campaign, and a notice where files of that have changed since.

    The fit does not hold the campaign: what is handed on stands in its folder, whatever the campaign is by now.
    """
    # A fit in memory needs no reader of results.
    from mechid.fits.load import load_campaign_of, result_folder
    from mechid.identification.refit.rebuild import changed_files
    from mechid.identification.result.fit_file import read_fit

    own = campaign if isinstance(campaign, Campaign) else load_campaign_of(source, campaign)
    fit = read_fit(result_folder(source))
    changed = ", ".join(changed_files(own, fit))
    notice = f"{changed}: changed since the fit, whose values are handed on; identify anew to have others"
    return fit, own, notice if changed else ""
