"""Public function that profiles the likelihood of a finished fit."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path

from mechid.campaign import Campaign
from mechid.fits.load import campaign_first, fit_from
from mechid.fits.refits import at_optimum, refit_journal
from mechid.identification.computation.progress import Listener
from mechid.identification.refit.profile import Point, Profile, profiles
from mechid.identification.result.fit import Fit
from mechid.shown import Shown


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Profiles(Shown, Mapping[str, Profile]):
    """Profiles by the dotted name of their parameter, as `profile` makes them."""

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
    """Profile the likelihood over one parameter after another, all others refitted.

    Parameters
    ----------
    fit : Fit or Path
        In memory, or the result folder of one. ``profile(campaign, fit, parameters)`` is accepted too.
    parameters : str or sequence of str
        Dotted names of parameters that the fit moved.
    campaign : Campaign, Path or None
        Of the fit, its records read; None takes the one that the fit holds or that its folder names.
    workers : int or None
        Threads; None takes one per core.
    executor : concurrent.futures.Executor or None
        Whose workers do the work, as `distributed.Client.get_executor()`; None leaves it to threads.
    listener : callable or None
        Called with each report of progress; None shows a line in a notebook and nothing elsewhere.
    journal : Path or None
        File in which what is worked out is noted, so that a stopped run can go on.
    resume : bool
        Go on where the last run in `journal` was stopped.

    Returns
    -------
    Profiles
        By name, in the file's units: values held, how the cost rises, 95 % intervals.

    Raises
    ------
    UsageError
        The fit did not move a parameter, or the journal is of other inputs.
    InputFileError
        The campaign is not the one of the fit.
    FitError
        The fit has no optimum.

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

        for name in names:
            optimum.one(name)
        noted = refit_journal(own, journal, resume=resume)
        done = profiles(optimum, names, workers=count, journal=noted, on_point=on_point)
    return Profiles(profiles=tuple(done), synthetic=own.required_campaign.synthetic, fit_digest=own.mechanism_digest)
