"""Public function for the export of a finished fit."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

from mechid.campaign import Campaign, load_campaign
from mechid.exports.export import Exported, write_export
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
    """Export a finished fit as C source, FMUs, linear models or tables.

    Parameters
    ----------
    fit : Fit or Path
        A fit, its result folder, or the campaign file next to the results.
    to : {"c", "fmu", "linear", "tables"}
    out : Path
        Folder for the files; created if missing.
    campaign : Campaign, Path or None
        Campaign of the fit, whose commands serve for the verification. None takes the campaign held by the fit or named
        in its folder.
    anyway : bool
        Whether to export a failed fit.
    folder : Path or None
        Result folder of a fit in memory, from which the residuals of its records are read.
    options : the target's `Options`, mapping of str to str, or None
        As ``mechid.exports.tables.options.Options(rates=(23.0, 46.0))``; None takes the defaults.

    Raises
    ------
    UsageError
        The target is unknown or cannot express the mechanism, or the folder is not writable.
    InputFileError
        The folder contains no fit or a damaged one, or the campaign is not found.
    FitError
        The fit has failed.

    Examples
    --------
    >>> import mechid
    >>> mechid.export("fit", to="tables", out="tables").written.files  # doctest: +SKIP
    """
    if isinstance(fit, Fit):
        # The folder provides the stored residuals of a fit in memory.
        source = fit if folder is None else replace(fit, folder=Path(folder))
        own = load_campaign(campaign) if isinstance(campaign, Path | str) else campaign or fit.campaign
    else:
        source, own, notice = read_with_campaign(Path(fit), campaign)
        if notice:
            warnings.warn(notice, stacklevel=2)
    return write_export(handover(source, own, anyway=anyway), to, Path(out), options)


def read_with_campaign(source: Path, campaign: Campaign | Path | str | None = None) -> tuple[Fit, Campaign, str]:
    """Read the fit of a result folder and its campaign, with a notice if the campaign files have changed since.

    The fit does not hold the campaign: the export uses the results in the folder, even if the campaign has changed.
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
