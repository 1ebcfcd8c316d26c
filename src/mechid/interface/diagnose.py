"""What the mechanism file lacks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from typing import Any

from mechid.campaign import Campaign
from mechid.identification.computation.progress import Listener
from mechid.identification.diagnosis import diagnosis
from mechid.identification.diagnosis.diagnosis import Diagnosis
from mechid.identification.result.fit import Fit
from mechid.interface.progress import listening


def diagnose(
    campaign: Campaign,
    fit: Fit | Mapping[str, Any],
    *,
    consider: Sequence[str] = (),
    workers: int | None = None,
    executor: Executor | None = None,
    listener: Listener | None = None,
) -> Diagnosis:
    """Say which effects the records of a finished fit ask for, and which these records cannot tell apart.

    Nothing of the fit is changed: what is found is said and proposed.

    Parameters
    ----------
    campaign : Campaign
        That of the fit, its records read.
    fit : Fit, or what its estimate.json holds
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
    >>> fit = mechid.load_fit("fit")  # doctest: +SKIP
    >>> [effect.name for effect in mechid.diagnose(fit.campaign, fit).missing]  # doctest: +SKIP
    ['stepper.detent:0.9deg']
    """
    asked = replace(campaign, considered=tuple(consider)) if consider else campaign
    with listening(listener) as tell:
        return diagnosis.diagnose(asked, fit, workers=workers, executor=executor, listener=tell)
