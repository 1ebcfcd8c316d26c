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
    """Say which effects the records of a finished fit ask for, and which these records cannot tell apart.

    Nothing of the fit is changed: what is found is said and proposed.

    Parameters
    ----------
    fit : Fit or Path
        In memory, or the result folder of one. ``diagnose(campaign, fit)`` is accepted too.
    campaign : Campaign, Path or None
        Of the fit, its records read; None takes the one that the fit holds or that its folder names.
    consider : sequence of str
        Look for these effects alone, or for all of their kind; none looks for all, or as the campaign says.
    workers : int or None
        Threads; None takes one per core.
    executor : concurrent.futures.Executor or None
        Whose workers do the work, as `distributed.Client.get_executor()`; None leaves it to threads.
    listener : callable or None
        Called with each report of progress; None shows a line in a notebook and nothing elsewhere.

    Raises
    ------
    InputFileError
        A file of the campaign is not the one that was identified, or an effect has no such name.
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
