"""Public function for choosing the records of the next test."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path

from mechid.campaign import Campaign
from mechid.designs.alternatives import Group, rival_groups
from mechid.designs.design import Design, make_design
from mechid.designs.design_file import DesignOptions, options_for, read_design_file
from mechid.designs.diagnosis_file import DiagnosedEffects, read_diagnosed
from mechid.errors import InputFileError, UsageError
from mechid.fits.load import fit_from, load_fit
from mechid.identification.computation.workforce import working_on
from mechid.identification.result.fit import Fit
from mechid.identification.uncertainty.visibility import chopper_objection
from mechid.progress.listening import line_receiver


def design(
    campaign: Campaign,
    options: DesignOptions | Path | str | None = None,
    *,
    fit: Fit | Path | str | None = None,
    diagnosis: Path | str | DiagnosedEffects | None = None,
    criterion: str | None = None,
    total_s: float | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    say: Callable[[str], None] | None = None,
) -> Design:
    """Choose the records of the next test, and rate step loss.

    Parameters
    ----------
    campaign : Campaign
        Its records may be planned or measured.
    options : DesignOptions, Path or None
        Candidates and limits, or the design file with them; None takes ``design.toml`` next to the campaign's file, or
        else the defaults.
    fit : Fit, Path or None
        Fit of the campaign, or its result folder, to choose further measurements. A fit in memory without a campaign is
        taken as one of this campaign, with its records read.
    diagnosis : Path, DiagnosedEffects or None
        Result folder of a diagnosis of that fit, or its content: records that separate its alternative effects come
        first.
    criterion : str or None
        "D", "A", "E" or a parameter's dotted name, in place of the options'.
    total_s : float or None
        Test time in s, including the time between records, in place of the options'.
    workers : int or None
        Number of threads; None takes one per core.
    executor : concurrent.futures.Executor or None
        External executor, as `distributed.Client.get_executor()`; None uses threads.
    say : callable or None
        Called with single lines; None shows the last one in a notebook and nothing elsewhere.

    Returns
    -------
    Design

    Raises
    ------
    FitError
        There is nothing to estimate, or the records cannot be simulated.
    UsageError
        The options name a missing item, a diagnosis is given without its fit, or the campaign does not consist of step
        commands.
    InputFileError
        A file is missing or wrong, or belongs to another fit, or the mechanism has a chopper, which no fit follows.

    Examples
    --------
    >>> import mechid
    >>> campaign = mechid.load_campaign("planned", read_records=False)  # doctest: +SKIP
    >>> chosen = mechid.design(campaign, criterion="D", total_s=120.0)  # doctest: +SKIP
    """
    count = workers or os.cpu_count() or 1
    if diagnosis is not None and fit is None:
        raise UsageError("diagnosis: give the fit too that was diagnosed")
    if objection := chopper_objection(campaign):
        raise InputFileError(f"{campaign.mechanism_path}: {objection}")
    requested = _options(campaign, options).with_overrides(criterion, total_s)
    with line_receiver(say) as tell, working_on(executor):
        diagnosed = _read_diagnosis(diagnosis, tell)
        optimum, rivals, digest = None, tuple[Group, ...](), ""
        if fit is not None:
            own = _fit_of(campaign, fit)
            optimum, digest = own.optimum_on(count), own.mechanism_digest
            if diagnosed:
                rivals = rival_groups(own, diagnosed, workers=count, say=tell)
        made = make_design(campaign, requested, fit=optimum, rivals=rivals, workers=count, say=tell)
    return replace(made, fit_digest=digest)


def _fit_of(campaign: Campaign, fit: Fit | Path | str) -> Fit:
    """Return a fit with its campaign; a result folder is read with the design's campaign file."""
    if not isinstance(fit, Path | str):
        return fit_from(fit, None if fit.campaign else campaign)
    return load_fit(fit, campaign.path if campaign.path.is_file() else campaign)


def _options(campaign: Campaign, options: DesignOptions | Path | str | None) -> DesignOptions:
    if isinstance(options, DesignOptions):
        return options
    return options_for(campaign.path) if options is None else read_design_file(options)


def _read_diagnosis(
    source: Path | str | DiagnosedEffects | None, tell: Callable[[str], None]
) -> DiagnosedEffects | None:
    if source is None:
        return None
    found = source if isinstance(source, DiagnosedEffects) else read_diagnosed(source)
    if not found.groups:
        tell(f"{found.path}: names no rival effects, so there is nothing to tell apart; the design is the usual one")
    return found
