"""Public function that refits records simulated at the estimate."""

from __future__ import annotations

import os
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path

from mechid.campaign import Campaign
from mechid.errors import UsageError
from mechid.fits.load import campaign_first, fit_from
from mechid.fits.refits import at_optimum, refit_journal
from mechid.identification.computation.progress import Listener
from mechid.identification.refit.bootstrap import Bootstrap, Draw
from mechid.identification.refit.bootstrap import bootstrap as bootstrapped
from mechid.identification.result.fit import Fit

# A list of many more would fill the memory before the first draw.
MOST_DRAWS = 1_000_000
"""Most draws."""


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
    """Refit records simulated at the estimate with similar noise, and determine the scatter of the estimates.

    Parameters
    ----------
    fit, campaign, workers, executor, listener, journal, resume
        As for `profile`; ``bootstrap(campaign, fit, draws)`` is accepted too.
    draws : int
        Number of draws, 2 to 1 000 000; with a journal, more can be added later.
    seed : int
        Seed of the noise.

    Returns
    -------
    Bootstrap
        All draws, with scatter, shift and quantiles of each parameter in the unit of the file.

    Raises
    ------
    UsageError
        The journal belongs to other inputs, or there are too many draws.
    InputFileError
        The campaign is not that of the fit.
    FitError
        The grade of the fit is C or failed, or no draw could be refitted.

    Examples
    --------
    >>> import mechid
    >>> scatter = mechid.bootstrap("fit", 40)  # doctest: +SKIP
    """
    if draws > MOST_DRAWS:
        raise UsageError(f"{draws} draws; {MOST_DRAWS} at most, which take months: some hundreds tell the scatter")
    count, ended = workers or os.cpu_count() or 1, 0
    own = fit_from(fit, campaign)
    with at_optimum(own, "bootstrap", count, executor, listener) as (optimum, report):

        def on_draw(draw: Draw) -> None:
            nonlocal ended
            ended += 1
            words = draw.outcome.code.replace("_", " ")
            report(f"{ended} of {draws} draws, number {draw.number} {words}", draw.cost)

        noted = refit_journal(own, journal, resume=resume)
        done = bootstrapped(optimum, draws, seed=seed, workers=count, journal=noted, on_draw=on_draw)
    return replace(done, synthetic=own.required_campaign.synthetic, fit_digest=own.mechanism_digest)
