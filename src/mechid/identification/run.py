"""Complete run of an identification: search, diagnosis, completed mechanism, suggestions."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from mechid.campaign import Campaign
from mechid.identification.computation.journal import Journal
from mechid.identification.computation.progress import Listener, silent
from mechid.identification.identify import identify as search
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import UNEXAMINED, FitOutcome, Grade

if TYPE_CHECKING:
    from mechid.identification.diagnosis.diagnosis import Diagnosis

INCOMPLETE_OUTCOMES = (FitOutcome.HORIZON, FitOutcome.FAILED)
"""Outcomes of an impatient search that a patient one may improve."""


@dataclass(frozen=True, kw_only=True)
class IdentifyRun:
    """Options of an identification.

    Attributes
    ----------
    seed : int
        Seed of the search; equal seeds give equal results.
    workers : int or None
        Number of threads; None uses one per core.
    near : mapping of str to float or None
        Values by dotted name, in the file's units, close to the optimum: see `mechid.identification.identify.identify`.
    complete : bool
        Add to the mechanism the effects that the data support, and identify again.
    resume : bool
        Continue the run in the journal of the result folder.
    truth : mapping of str to float or None
        True values by dotted name, in the file's units, of simulated records; the report then says so.
    """

    seed: int = 0
    workers: int | None = None
    near: Mapping[str, float] | None = None
    complete: bool = False
    resume: bool = False
    truth: Mapping[str, float] | None = None


class Companion:
    """Actions that accompany an identification. This class keeps its fits in memory; a subclass may write files.

    Attributes
    ----------
    kept : list of Fit
        Fits of the finished searches.
    journal : Journal or None
        Journal of the searches with the mechanism as written.
    keep_early : callable or None
        Called by a search with an interim fit before the search has ended.
    """

    journal: Journal | None = None
    keep_early: Callable[[Fit], object] | None = None

    def __init__(self, listener: Listener = silent) -> None:
        self.listener = listener
        self.kept: list[Fit] = []

    def progress(self) -> AbstractContextManager[Listener]:
        """Return a context for the searches with one mechanism; it gives the listener of their progress."""
        return nullcontext(self.listener)

    def keep(self, fit: Fit) -> None:
        """Keep a fit as soon as its search has ended."""
        self.kept.append(fit)

    def complete(self, campaign: Campaign, found: Diagnosis) -> Campaign:
        """Return the campaign with the mechanism that a diagnosis proposes; the same one where it proposes none."""
        return replace(campaign, mechanism=found.mechanism) if found.mechanism else campaign

    def judge(self, fit: Fit) -> None:
        """Judge the final fit before its suggestions are computed."""

    def say(self, line: str) -> None:
        """Tell the user a line."""


def identify(campaign: Campaign, run: IdentifyRun, listener: Listener = silent) -> Fit:
    """Identify the free parameters of a campaign's mechanism from its records.

    If it is interrupted after a search has ended, the fit of that search is returned, with a warning that it has not
    been examined.

    Raises
    ------
    FitError
        If no parameter is free, or no record has use "estimate".
    """
    companion = Companion(listener)
    try:
        return run_identification(campaign, run, companion)
    except KeyboardInterrupt:
        if not companion.kept:
            raise
        return mark_unexamined(companion.kept[-1])


def run_identification(campaign: Campaign, run: IdentifyRun, companion: Companion) -> Fit:
    """Return the fit of a campaign with its suggestions; of the completed mechanism if `run.complete` is set.

    Raises
    ------
    FitError
        If no parameter is free, or no record has use "estimate".
    KeyboardInterrupt
        If it was interrupted after a search has ended; `companion` holds the fit of that search.
    """
    with companion.progress() as listener:
        fit, found = (search_and_diagnose if run.complete else search_only)(campaign, run, companion, listener)
    if fit.outcome is FitOutcome.INTERRUPTED:
        return fit
    if found is not None:
        whole = companion.complete(campaign, found)
        fit = replace(fit, completed=())
        if found.mechanism is not None:
            with companion.progress() as listener:
                fit = fit_completed_mechanism(whole, found, run, listener)
    companion.judge(fit)
    if fit.grade in (Grade.A, Grade.FAILED):
        return fit
    # A complete fit needs no diagnosis, whose import takes a tenth of all of them.
    from mechid.identification.diagnosis.start import add_suggestions

    return add_suggestions(fit, run.workers or os.cpu_count() or 1, say=companion.say)


def mark_unexamined(fit: Fit) -> Fit:
    """Add the warning that the steps after the search of a fit have not been done."""
    return fit if fit.outcome is FitOutcome.INTERRUPTED else replace(fit, warnings=(*fit.warnings, UNEXAMINED))


def search_only(
    campaign: Campaign, run: IdentifyRun, companion: Companion, listener: Listener = silent
) -> tuple[Fit, Diagnosis | None]:
    """Return the fit of the mechanism as written, and no diagnosis."""
    fit = _search(campaign, run, companion, listener)()
    companion.keep(fit)
    return fit, None


def search_and_diagnose(
    campaign: Campaign, run: IdentifyRun, companion: Companion, listener: Listener = silent
) -> tuple[Fit, Diagnosis | None]:
    """Return the fit of the mechanism as written and its diagnosis; None if the fit has failed or was interrupted.

    If the best start does not follow the records, as written or with added terms, the diagnosis runs at once. A patient
    search takes longer, and runs only where the diagnosis finds no mechanism that follows them.
    """
    from mechid.identification.diagnosis.diagnosis import diagnose

    search_as_written = _search(campaign, run, companion, listener)
    fit = search_as_written(patient=False)
    companion.keep(fit)
    if fit.outcome is FitOutcome.INTERRUPTED:
        return fit, None
    found = None if fit.grade is Grade.FAILED else diagnose(fit, workers=run.workers, listener=listener)
    if fit.outcome not in INCOMPLETE_OUTCOMES or (found and found.mechanism and found.share == 1.0):
        return fit, found
    patient = search_as_written()
    companion.keep(patient)
    if patient.grade is Grade.FAILED or patient.outcome is FitOutcome.INTERRUPTED:
        return patient, None
    return patient, diagnose(patient, workers=run.workers, listener=listener)


def _search(campaign: Campaign, run: IdentifyRun, companion: Companion, listener: Listener) -> partial[Fit]:
    """Return the search with the mechanism as written; it takes `patient`."""
    return partial(
        search,
        campaign,
        seed=run.seed,
        workers=run.workers,
        near=run.near,
        listener=listener,
        journal=companion.journal,
        keep=companion.keep_early,
    )


def fit_completed_mechanism(whole: Campaign, found: Diagnosis, run: IdentifyRun, listener: Listener = silent) -> Fit:
    """Fit a campaign whose mechanism has the effects that a diagnosis proposes, from the proposed values.

    Values that do not follow the records to their ends are no warm start, and values that lead to a fit of grade C may
    be on a wrong branch. In both cases the whole search runs again, since with the effect it takes another path.

    Raises
    ------
    KeyboardInterrupt
        If it was interrupted: only the fit of the mechanism as written is finished.
    """
    again = partial(search, whole, seed=run.seed, workers=run.workers, listener=listener)
    near = {p.name: p.value for p in whole.mechanism.free} if found.share == 1.0 else None
    fit = again(near=near)
    if near and fit.grade is Grade.C and fit.outcome is not FitOutcome.INTERRUPTED:
        other = again(patient=False)
        fit = other if other.grade.good else fit
    if fit.outcome is FitOutcome.INTERRUPTED:
        raise KeyboardInterrupt
    return replace(fit, completed=tuple({"step": number, **asdict(step)} for number, step in enumerate(found.steps, 1)))
