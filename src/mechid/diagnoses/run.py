"""Public function that diagnoses a finished fit."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path

from mechid.campaign import Campaign
from mechid.fits.load import campaign_first, fit_from
from mechid.identification.computation.progress import Listener
from mechid.identification.diagnosis import diagnosis
from mechid.identification.diagnosis.diagnosis import Diagnosis
from mechid.identification.result.fit import Fit
from mechid.progress.listening import progress_listener


@campaign_first
def diagnose(
    fit: Fit | Path | str,
    *,
    campaign: Campaign | Path | str | None = None,
    consider: Sequence[str] = (),
    workers: int | None = None,
    executor: Executor | None = None,
    listener: Listener | None = None,
) -> Diagnosis:
    """Find effects that the records of a finished fit support, and effects that they cannot distinguish.

    The fit is not changed; the effects found are reported and proposed.

    Parameters
    ----------
    fit : Fit or Path
        A fit in memory, or its result folder. ``diagnose(campaign, fit)`` is accepted too.
    campaign : Campaign, Path or None
        Campaign of the fit with its records read; None takes the one held by the fit or named in its folder.
    consider : sequence of str
        Effects or kinds of effects to consider; empty for all, or for those in the campaign file.
    workers : int or None
        Threads; None takes one per core.
    executor : concurrent.futures.Executor or None
        External executor for the work, as `distributed.Client.get_executor()`; None uses threads.
    listener : callable or None
        Called with each progress report; None shows a line in notebooks and nothing elsewhere.

    Raises
    ------
    InputFileError
        A file of the campaign differs from the identified one, or the name of an effect is unknown.
    FitError
        The fit has failed.

    Examples
    --------
    >>> import mechid
    >>> [effect.name for effect in mechid.diagnose("fit").missing]  # doctest: +SKIP
    ['stepper.detent:0.9deg']
    """
    own = fit_from(fit, campaign)
    if consider:
        own = replace(own, campaign=replace(own.required_campaign, considered=tuple(consider)))
    with progress_listener(listener) as tell:
        found = diagnosis.diagnose(own, workers=workers, executor=executor, listener=tell)
    return replace(found, fit_digest=own.mechanism_digest)
