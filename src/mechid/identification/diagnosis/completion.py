"""A mechanism that completes itself: identified, diagnosed, and identified again with what its records say it lacks."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import asdict, replace
from functools import partial

from mechid.campaign import Campaign
from mechid.identification.computation.journal import Journal
from mechid.identification.computation.progress import Listener, silent
from mechid.identification.computation.workforce import working_on
from mechid.identification.diagnosis.diagnosis import Diagnosis, diagnose
from mechid.identification.diagnosis.suggestion import with_suggestions
from mechid.identification.identify import identify as identified
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import Grade
from mechid.identification.result.outcome import UNEXAMINED, FitOutcome

SHORT = (FitOutcome.HORIZON, FitOutcome.FAILED)
"""Where a search without patience ends that a patient one may better."""


def identify(
    campaign: Campaign,
    *,
    seed: int = 0,
    workers: int | None = None,
    executor: Executor | None = None,
    listener: Listener = silent,
    journal: Journal | None = None,
    near: Mapping[str, float] | None = None,
    complete: bool = False,
) -> Fit:
    """Identify the free parameters of a campaign's mechanism from its records.

    Parameters
    ----------
    campaign, seed, workers, executor, listener, journal, near
        As of `mechid.identification.identify.identify`.
    complete : bool
        Add to the mechanism what its records say it lacks, and identify again; `completed` of the fit has the steps,
        and its `mechanism` and `parameters` are those of the completed one.

    Raises
    ------
    FitError
        If nothing is free, or no record is to be estimated from.
    """
    kept: list[Fit] = []
    with working_on(executor):
        try:
            if not complete:
                fit = identified(campaign, seed=seed, workers=workers, listener=listener, journal=journal, near=near)
                kept.append(fit)
                return with_suggestions(campaign, fit, workers or os.cpu_count() or 1)
            fit, found = examined(
                campaign, seed=seed, workers=workers, listener=listener, journal=journal, near=near, keep=kept.append
            )
            if found is None:
                return fit
            if found.mechanism is None:
                return replace(fit, completed=())
            whole = replace(campaign, mechanism=found.mechanism)
            return identified_with(whole, found, seed=seed, workers=workers, listener=listener)
        except KeyboardInterrupt:
            if not kept:
                raise
            return unexamined(kept[-1])


def unexamined(fit: Fit) -> Fit:
    """Return a fit that says that what follows its search has not been done."""
    return fit if fit.outcome is FitOutcome.INTERRUPTED else replace(fit, warnings=(*fit.warnings, UNEXAMINED))


def examined(
    campaign: Campaign,
    *,
    seed: int = 0,
    workers: int | None = None,
    listener: Listener = silent,
    journal: Journal | None = None,
    near: Mapping[str, float] | None = None,
    keep: Callable[[Fit], object] = lambda fit: None,
) -> tuple[Fit, Diagnosis | None]:
    """Return a fit of the mechanism as written and its diagnosis; none of a fit that has failed or was interrupted.

    `keep` is called with each fit before it is diagnosed.

    Where the best start does not follow the records, as written or with terms beside, the diagnosis asks at once what
    is missing: a patient search takes longer, and goes first only where that finds nothing that follows them.
    """
    search = partial(
        identified, campaign, seed=seed, workers=workers, listener=listener, journal=journal, near=near, keep=keep
    )
    fit = search(patient=False)
    keep(fit)
    if fit.outcome is FitOutcome.INTERRUPTED:
        return fit, None
    found = None if fit.grade is Grade.FAILED else diagnose(campaign, fit, workers=workers, listener=listener)
    if fit.outcome not in SHORT or (found and found.mechanism and found.share == 1.0):
        return fit, found
    patient = search()
    keep(patient)
    if patient.grade is Grade.FAILED or patient.outcome is FitOutcome.INTERRUPTED:
        return patient, None
    return patient, diagnose(campaign, patient, workers=workers, listener=listener)


def identified_with(
    whole: Campaign, found: Diagnosis, *, seed: int = 0, workers: int | None = None, listener: Listener = silent
) -> Fit:
    """Return the fit of a campaign whose mechanism has what a diagnosis proposes, begun at the values found with it.

    Values that do not follow the records to their ends are no more than a start, and those that lead to a fit of grade
    C may be of a wrong branch: then all is searched again, since a search with the effect goes another way.

    Raises
    ------
    KeyboardInterrupt
        It was interrupted: the fit of the mechanism as written is finished, and is what there is.
    """
    near = {p.name: p.value for p in whole.mechanism.free} if found.share == 1.0 else None
    fit = identified(whole, seed=seed, workers=workers, listener=listener, near=near)
    if near and fit.grade is Grade.C and fit.outcome is not FitOutcome.INTERRUPTED:
        again = identified(whole, seed=seed, workers=workers, listener=listener, patient=False)
        fit = again if again.grade.good else fit
    if fit.outcome is FitOutcome.INTERRUPTED:
        raise KeyboardInterrupt
    return replace(fit, completed=tuple({"step": number, **asdict(step)} for number, step in enumerate(found.steps, 1)))
