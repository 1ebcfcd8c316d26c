"""Finished fits that the functions begin from: in memory, or read from a result folder with their campaign."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import ParamSpec, TypeVar, cast

from mechid.campaign import Campaign, load_campaign, load_mechanism
from mechid.campaign.campaign_file import FILE_NAME as CAMPAIGN_NAME
from mechid.errors import InputFileError, UsageError
from mechid.identification.result.estimate_file import ERROR_TABLES, read_estimate
from mechid.identification.result.fit import ESTIMATE_NAME, Fit
from mechid.identification.result.fit_file import read_fit
from mechid.identification.result.journal_file import identified_campaign

COMPLETED_NAME = "mechanism_completed.toml"
"""Of the mechanism to which a fit was completed, in its folder."""
P = ParamSpec("P")
T = TypeVar("T")
NEEDED = (*ERROR_TABLES, "records", "provenance")
"""Tables of estimate.json without which nothing can go on from a fit."""


def load_fit(folder: Path | str, campaign: Campaign | Path | str | None = None) -> Fit:
    """Return the fit that ``mechid identify`` or `identify_into` left in a folder.

    Parameters
    ----------
    folder : Path
        The result folder, or the campaign file beside which the results lie.
    campaign : Campaign, Path or None
        Of which it was identified; None takes the one in the folder, else the one that its journal names.

    Raises
    ------
    InputFileError
        There is no such fit, it is damaged, or a file of its campaign has changed since.
    RecordError
        A record's file is missing or cannot be used.

    Examples
    --------
    >>> import mechid
    >>> mechid.load_fit("fit").grade  # doctest: +SKIP
    <Grade.A: 'A'>
    """
    source = Path(folder)
    if isinstance(campaign, Campaign):
        if not source.is_dir():
            raise UsageError(f"{source}: is no folder; give the result folder of the fit")
        return read_fit(source, _load_completed(campaign, source))
    return read_fit(result_folder(source), load_campaign_of(source, campaign))


def load_campaign_of(source: Path, campaign: Path | str | None = None) -> Campaign:
    """Return the campaign of a result folder, with the mechanism to which its fit was completed.

    It may have changed since the fit: `read_fit` and `changed_files` detect this.

    Parameters
    ----------
    source : Path
        The result folder, or the campaign file beside which the results lie.
    campaign : Path or None
        Its file; None takes the one in the folder, else the one that its journal names.

    Raises
    ------
    InputFileError
        There is no such folder, no whole estimate.json in it, or the campaign cannot be found.
    """
    if not source.exists():
        raise InputFileError(f"{source}: there is no such folder or file; give the result folder of mechid identify")
    folder = result_folder(source)
    read_estimate(folder / ESTIMATE_NAME, needs=NEEDED)  # refuse a damaged fit before its records are read
    return load_campaign(_campaign_file(source, campaign), mechanism_file=completed_file(folder))


def result_folder(source: Path) -> Path:
    """Return the folder of results: the one given, or that of the campaign file given."""
    return source if source.is_dir() else source.parent


def fit_from(fit: Fit | Path | str, campaign: Campaign | Path | str | None = None) -> Fit:
    """Return a fit in memory, or the one of a result folder, together with its campaign.

    Parameters
    ----------
    fit : Fit or Path
    campaign : Campaign, Path or None
        Takes the place of the campaign that a fit in memory holds; of a folder as of `load_fit`.

    Raises
    ------
    UsageError
        The fit is in memory and holds no campaign, and none is given.
    """
    if isinstance(fit, Path | str):
        return load_fit(fit, campaign)
    if not isinstance(fit, Fit):
        raise UsageError(f"fit: found a {type(fit).__name__}; give a Fit, or the result folder of mechid identify")
    if campaign is not None:
        own = campaign if isinstance(campaign, Campaign) else load_campaign(campaign)
        return replace(fit, campaign=campaign_of_fit(own, fit))
    return replace(fit, campaign=fit.required_campaign)


def campaign_of_fit(campaign: Campaign, fit: Fit) -> Campaign:
    """Return a campaign with the mechanism to which its fit was completed; the same one where it was not."""
    return replace(campaign, mechanism=fit.start_mechanism) if fit.completed else campaign


def completed_file(folder: Path) -> Path | None:
    """Return the mechanism file of a result folder that identify has completed; None where it is the campaign's."""
    found = read_estimate(folder / ESTIMATE_NAME)
    return folder / COMPLETED_NAME if found.get("completed") is not None else None


def campaign_first(function: Callable[P, T]) -> Callable[P, T]:
    """Return a function of a fit that accepts its campaign before the fit too, instead of as ``campaign=``."""

    @wraps(function)
    def either_order(*given: object, **options: object) -> object:
        if given and isinstance(given[0], Campaign):
            given, options = given[1:], {"campaign": given[0], **options}
        return cast("Callable[..., object]", function)(*given, **options)

    return cast("Callable[P, T]", either_order)


def _campaign_file(source: Path, campaign: Path | str | None) -> Path:
    """Return the campaign file of a result folder: the one given, beside the results, or named by their journal."""
    if campaign is not None:
        return Path(campaign)
    beside = source if source.is_file() else source / CAMPAIGN_NAME
    return beside if beside.is_file() else identified_campaign(source)


def _load_completed(campaign: Campaign, folder: Path) -> Campaign:
    """Return a campaign with the mechanism file to which the fit in a folder was completed."""
    file = completed_file(folder)
    if file is None or file.resolve() == campaign.mechanism_path.resolve():
        return campaign
    mechanism = load_mechanism(file)
    mechanism = replace(mechanism, plant=mechanism.plant.with_outputs([*campaign.mechanism.plant.outputs]))
    # A campaign in memory was identified without files, so that the digests of its fit do not name this one.
    path = file if campaign.path.is_file() else campaign.mechanism_path
    return replace(campaign, mechanism=mechanism, mechanism_path=path)
