"""Public function that profiles the likelihood of a finished fit."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path

from mechid.campaign import Campaign
from mechid.display import DisplayedResult
from mechid.fits.load import campaign_first, fit_from
from mechid.fits.refits import at_optimum, refit_journal
from mechid.identification.computation.progress import Listener
from mechid.identification.refit.profile import Point, Profile, profiles
from mechid.identification.result.fit import Fit


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Profiles(DisplayedResult, Mapping[str, Profile]):
    """Profiles by the dotted name of their parameter, made by `profile`."""

    profiles: tuple[Profile, ...]
    synthetic: bool = False
    fit_digest: str = ""

    def __getitem__(self, name: str) -> Profile:
        return {one.name: one for one in self.profiles}[name]

    def __iter__(self) -> Iterator[str]:
        return (one.name for one in self.profiles)

    def __len__(self) -> int:
        return len(self.profiles)


@campaign_first
def profile(
    fit: Fit | Path | str,
    parameters: str | Sequence[str],
    *,
    campaign: Campaign | Path | str | None = None,
    workers: int | None = None,
    executor: Executor | None = None,
    listener: Listener | None = None,
    journal: Path | str | None = None,
    resume: bool = False,
) -> Profiles:
    """Compute likelihood profiles of parameters, one after the other, with all others refitted.

    Parameters
    ----------
    fit : Fit or Path
        A fit in memory, or its result folder. ``profile(campaign, fit, parameters)`` is accepted too.
    parameters : str or sequence of str
        Dotted names of fitted parameters.
    campaign : Campaign, Path or None
        Campaign of the fit with its records read; None takes the one held by the fit or named in its folder.
    workers : int or None
        Threads; None takes one per core.
    executor : concurrent.futures.Executor or None
        External executor for the work, as `distributed.Client.get_executor()`; None uses threads.
    listener : callable or None
        Called with each progress report; None shows a line in notebooks and nothing elsewhere.
    journal : Path or None
        File in which intermediate results are stored, so that an interrupted run can be resumed.
    resume : bool
        Whether to resume the last run in `journal`.

    Returns
    -------
    Profiles
        Profiles by name, in the units of the file: fixed values, rise of the cost, and 95 % intervals.

    Raises
    ------
    UsageError
        A parameter was not fitted, or the journal belongs to other inputs.
    InputFileError
        The campaign is not that of the fit.
    FitError
        The grade of the fit is C or failed.

    Examples
    --------
    >>> import mechid
    >>> mechid.profile("fit", "gear.stiffness")["gear.stiffness"].interval  # doctest: +SKIP
    (905.1, 921.8)
    """
    names = [parameters] if isinstance(parameters, str) else list(dict.fromkeys(parameters))
    count = workers or os.cpu_count() or 1
    own = fit_from(fit, campaign)
    with at_optimum(own, "profile", count, executor, listener) as (optimum, report):

        def on_point(name: str, point: Point) -> None:
            report(f"{name} at {point.value:.9g}, cost rises by {point.rise:.3g}", None)

        # A name without an estimate is refused before the first refit.
        for name in names:
            optimum.estimate_of(name)
        noted = refit_journal(own, journal, resume=resume)
        done = profiles(optimum, names, workers=count, journal=noted, on_point=on_point)
    return Profiles(profiles=tuple(done), synthetic=own.required_campaign.synthetic, fit_digest=own.mechanism_digest)
