"""A finished fit refitted: over values of a parameter, and of records drawn anew."""

from __future__ import annotations

import os
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from mechid.campaign import Campaign
from mechid.errors import UsageError
from mechid.fits.load import campaign_first, fit_from
from mechid.identification.computation.journal import Journal, digest
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.computation.progress import Listener, Progress
from mechid.identification.computation.workforce import working_on
from mechid.identification.output_error.identity import campaign_digests
from mechid.identification.refit.bootstrap import Bootstrap, Draw
from mechid.identification.refit.bootstrap import bootstrap as bootstrapped
from mechid.identification.refit.profile import Point, Profile, profiles
from mechid.identification.result.fit import Fit, Optimum
from mechid.progress.listening import listening
from mechid.shown import Shown

TellShare = Callable[[str, float | None], None]
MOST_DRAWS = 1_000_000
"""Of a bootstrap; the list of many more fills the memory before the first."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Profiles(Shown, Mapping[str, Profile]):
    """Profiles by the dotted name of their parameter, as `profile` makes them."""

    profiles: tuple[Profile, ...]
    synthetic: bool = False

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
    with _at_optimum(own, "profile", count, executor, listener) as (optimum, report):

        def on_point(name: str, point: Point) -> None:
            report(f"{name} at {point.value:.9g}, cost rises by {point.rise:.3g}", None)

        for name in names:
            optimum.one(name)
        noted = _journal(own, journal, resume=resume)
        done = profiles(optimum, names, workers=count, journal=noted, on_point=on_point)
    return Profiles(profiles=tuple(done), synthetic=own.required_campaign.synthetic)


@campaign_first
def bootstrap(
    fit: Fit | Path | str,
    draws: int = 200,
    *,
    campaign: Campaign | Path | str | None = None,
    seed: int = 0,
    workers: int | None = None,
    executor: Executor | None = None,
    listener: Listener | None = None,
    journal: Path | str | None = None,
    resume: bool = False,
) -> Bootstrap:
    """Refit records simulated at the estimate, with noise like theirs, and see how estimates scatter.

    Parameters
    ----------
    fit, campaign, workers, executor, listener, journal, resume
        As of `profile`; ``bootstrap(campaign, fit, draws)`` is accepted too.
    draws : int
        How many, 2 to 1 000 000; with a journal more can be added to a run.
    seed : int
        Of the noise.

    Returns
    -------
    Bootstrap
        All draws, and scatter, shift and quantiles of each parameter in the file's unit.

    Raises
    ------
    UsageError
        The journal is of other inputs, or there are too many draws.
    InputFileError
        The campaign is not the one of the fit.
    FitError
        The fit has no optimum, or no draw could be refitted.

    Examples
    --------
    >>> import mechid
    >>> scatter = mechid.bootstrap("fit", 40)  # doctest: +SKIP
    """
    if draws > MOST_DRAWS:
        raise UsageError(f"{draws} draws; {MOST_DRAWS} at most, which take months: some hundreds tell the scatter")
    count, ended = workers or os.cpu_count() or 1, 0
    own = fit_from(fit, campaign)
    with _at_optimum(own, "bootstrap", count, executor, listener) as (optimum, report):

        def on_draw(draw: Draw) -> None:
            nonlocal ended
            ended += 1
            words = draw.outcome.code.replace("_", " ")
            report(f"{ended} of {draws} draws, number {draw.number} {words}", draw.cost)

        noted = _journal(own, journal, resume=resume)
        done = bootstrapped(optimum, draws, seed=seed, workers=count, journal=noted, on_draw=on_draw)
    return replace(done, synthetic=own.required_campaign.synthetic)


@contextmanager
def _at_optimum(
    fit: Fit, stage: str, workers: int, executor: Executor | None, listener: Listener | None
) -> Iterator[tuple[Optimum, TellShare]]:
    """Return the optimum of a fit, and the function that reports the progress of its refits."""
    began = time.perf_counter()
    with one_core_algebra(), working_on(executor), listening(listener) as tell:
        yield (
            fit.optimum_on(workers),
            lambda words, cost: tell(Progress(1, 1, stage, words, cost, time.perf_counter() - began)),
        )


def _journal(fit: Fit, path: Path | str | None, *, resume: bool) -> Journal | None:
    if path is None:
        return None
    values = [[name, p.value, str(p.status)] for name, p in fit.parameters.items()]
    inputs = {**campaign_digests(fit.required_campaign), "estimate.json": digest(values)}
    opened = Journal.opened(Path(path), inputs, resume=resume)
    if opened.notice:
        warnings.warn(opened.notice, stacklevel=2)
    return opened
