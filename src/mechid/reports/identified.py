"""An identification with all that it leaves in a folder: its journal, its results, its report."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mechid.analysis import RecordValidation, validate
from mechid.campaign import Campaign, load_campaign
from mechid.campaign.mechanism_text import write_mechanism
from mechid.errors import UnwritableError
from mechid.identification.computation.journal import Journal
from mechid.identification.computation.progress import Listener, Progress
from mechid.identification.diagnosis.completion import examined, identified_with, unexamined
from mechid.identification.diagnosis.suggestion import with_suggestions
from mechid.identification.identify import identify
from mechid.identification.output_error.identity import campaign_digests
from mechid.identification.result.estimated_mechanism import signed
from mechid.identification.result.fit import Fit
from mechid.identification.result.journal_file import FILE_NAME, StageLines
from mechid.identification.result.outcome import FitOutcome
from mechid.reports.fit.illustration import Illustration
from mechid.reports.fit.numbers import report_data
from mechid.reports.fit.results import ESTIMATED, MECHANISM_NAME, REPORT_NAME, estimated_text, write_results
from mechid.reports.pens import Pens

if TYPE_CHECKING:
    from mechid.identification.diagnosis.diagnosis import Diagnosis

ESTIMATED_NAME = "mechanism_estimated.toml"
"""Of the estimated mechanism, where the campaign's own lies in the folder and keeps its name."""
FIRST_LETTERS = 1000
"""Of a mechanism file, in which mechid writes that it is estimated."""
COMPLETED_NAME = "mechanism_completed.toml"


@dataclass(frozen=True, kw_only=True)
class Audience:
    """Who hears of an identification.

    Parameters
    ----------
    followed : callable
        Gives a context for each search, which yields who listens to its progress.
    say : callable
        Called with single lines.
    """

    followed: Callable[[], AbstractContextManager[Listener]]
    say: Callable[[str], None]


@dataclass(frozen=True, kw_only=True)
class Identified:
    """A fit, what its report shows (`report_data`), and the files left."""

    fit: Fit
    data: Mapping[str, Any]
    files: tuple[Path, ...]


def identified_into(
    campaign: Campaign,
    folder: Path,
    audience: Audience,
    *,
    seed: int = 0,
    workers: int | None = None,
    truth: Mapping[str, float] | None = None,
    resume: bool = False,
    complete: bool = False,
) -> Identified:
    """Identify a campaign and leave journal, results and report in a folder, also where it failed.

    The results are there as soon as the search has ended; what follows, which may be interrupted or fail, replaces
    them. Where the search is interrupted they are the best values so far, without a report.

    Parameters
    ----------
    campaign : Campaign
    folder : Path
        Made with its parents where it is missing.
    audience : Audience
    seed, workers
        As of `mechid.identification.identify.identify`.
    truth : mapping or None
        That of a synthetic campaign; where it is given the report says so.
    resume : bool
        The last run in the folder's journal is taken up where it was stopped.
    complete : bool
        The mechanism gets what its records say it lacks, and is identified again.

    Raises
    ------
    FitError
        Nothing is free, or no record is to be estimated from.
    UsageError
        The folder cannot be written to, or the run to be resumed had other inputs.
    KeyboardInterrupt
        It was interrupted after the search; the estimate in the folder says that it was not examined.
    """
    kept: list[Identified] = []

    def keep(found: Fit) -> None:
        kept.append(_kept(campaign, unexamined(found), folder, truth))

    with Pens() as pens, ExitStack() as entered:  # pens load beside the search, which leaves a core idle now and then
        with _told_what_is_kept(kept, folder, audience.say):
            fit, found, stages = _identified(
                campaign, folder, audience, seed, workers, keep, resume=resume, complete=complete
            )
            if fit.outcome is FitOutcome.INTERRUPTED:
                stages.finish(fit)
                return replace(kept[-1], files=(*kept[-1].files, folder / FILE_NAME))
            diagnosed: list[Path] = []
            if found is not None:
                campaign, fit, diagnosed = _completed(campaign, fit, found, folder, audience, seed, workers)
            illustration = entered.enter_context(Illustration(campaign, fit, folder, pens))
            validation = validate(campaign, fit, illustration.begin)
            fit = with_suggestions(campaign, fit, workers or os.cpu_count() or 1, say=audience.say)
            done = _kept(campaign, fit, folder, truth, validation)
        stages.finish(fit)
        shown = _report(done.data, campaign, done.fit, validation, folder, audience.say, illustration)
    return replace(done, files=(*done.files, folder / FILE_NAME, *diagnosed, *shown))


def _kept(
    campaign: Campaign,
    fit: Fit,
    folder: Path,
    truth: Mapping[str, float] | None,
    validation: Mapping[str, RecordValidation] | None = None,
) -> Identified:
    """Write the results of a fit into a folder, and return them; without a validation those that its search gave."""
    name = mechanism_name(campaign, folder)
    fit = replace(fit, synthetic=fit.synthetic or truth is not None)
    fit = signed(fit, name, estimated_text(fit))
    data = report_data(fit, truth, validation=validation)
    files = write_results(fit, data, folder, mechanism_name=name, validation=validation)
    return Identified(fit=fit, data=data, files=tuple(files))


@contextmanager
def _told_what_is_kept(kept: Sequence[Identified], folder: Path, say: Callable[[str], None]) -> Iterator[None]:
    """Say, where the run is interrupted after its search, where its estimate is and how to go on."""
    try:
        yield
    except KeyboardInterrupt:
        if kept:
            say(
                f"the estimate is in {folder}, not examined any further; the same command with --resume goes on, "
                f'"mechid report {folder}" makes its report'
            )
        raise


def mechanism_name(campaign: Campaign, folder: Path) -> str:
    """Return what the estimated mechanism is called in a folder, where one may lie that somebody has written.

    That is the campaign's own, or any in which mechid has not written that it is estimated.
    """
    place = folder / MECHANISM_NAME
    is_own = place.resolve() == campaign.mechanism_path.resolve()
    return ESTIMATED_NAME if is_own or _is_written_by_hand(place) else MECHANISM_NAME


def _is_written_by_hand(file: Path) -> bool:
    try:
        with file.open(encoding="utf-8", errors="replace") as text:
            return ESTIMATED not in text.read(FIRST_LETTERS)
    except OSError:  # as where there is none
        return False


def _identified(
    campaign: Campaign,
    folder: Path,
    audience: Audience,
    seed: int,
    workers: int | None,
    keep: Callable[[Fit], None],
    *,
    resume: bool,
    complete: bool,
) -> tuple[Fit, Diagnosis | None, StageLines]:
    """Run the identification, and a diagnosis to complete it by, with its progress told and in the journal.

    `keep` is called with each fit as soon as its search has ended.
    """
    path = folder / FILE_NAME
    about = {"campaign": str(campaign.path.resolve()), "seed": seed, "mechid": version("mechid")}
    journal = Journal.opened(path, identification_inputs(campaign, seed), resume=resume, **about)
    if journal.notice:
        audience.say(f"warning: {journal.notice}")
    if resume:
        audience.say(f"{path}: {len(journal.known)} steps are there already")
    stages = StageLines(journal)
    with audience.followed() as listener:

        def tell(progress: Progress) -> None:
            listener(progress)
            stages.tell(progress)

        found = None
        if complete:
            fit, found = examined(campaign, seed=seed, workers=workers, listener=tell, journal=journal, keep=keep)
        else:
            fit = identify(campaign, seed=seed, workers=workers, listener=tell, journal=journal, keep=keep)
            keep(fit)
    return fit, found, stages


def identification_inputs(campaign: Campaign, seed: int) -> dict[str, str]:
    """Return the digests by which the journal of an identification knows its inputs."""
    return {**campaign_digests(campaign), "seed": str(seed)}


def _completed(
    campaign: Campaign, fit: Fit, found: Diagnosis, folder: Path, audience: Audience, seed: int, workers: int | None
) -> tuple[Campaign, Fit, list[Path]]:
    """Identify again with the mechanism that a diagnosis proposes; the steps stay with the fit."""
    from mechid.reports.diagnosis.contents import diagnosis_data
    from mechid.reports.diagnosis.files import PROPOSED, write_diagnosis

    files = write_diagnosis(found, diagnosis_data(found), folder)
    if found.mechanism is None:
        return campaign, replace(fit, completed=()), files
    path = folder / COMPLETED_NAME
    write_mechanism(found.mechanism, path, PROPOSED)
    in_files = campaign.path.is_file()
    whole = load_campaign(campaign.path, mechanism_file=path) if in_files else _having(campaign, found)
    with audience.followed() as listener:
        again = identified_with(whole, found, seed=seed, workers=workers, listener=listener)
    return whole, again, [path, *files]


def _having(campaign: Campaign, found: Diagnosis) -> Campaign:
    """Return a campaign in memory with the mechanism that a diagnosis proposes."""
    return replace(campaign, mechanism=found.mechanism or campaign.mechanism)


def _report(
    data: Mapping[str, Any],
    campaign: Campaign,
    fit: Fit,
    validation: Mapping[str, RecordValidation],
    folder: Path,
    say: Callable[[str], None],
    illustration: Illustration,
) -> list[Path]:
    """Write the report; where a figure or a text fails say so, since the estimate is on disk already."""
    say("making the report ...")
    try:
        from mechid.reports.fit.files import write_report

        files = write_report(data, campaign, fit, validation, folder, illustration)
        return [path for path in files if path.name != REPORT_NAME]
    except KeyboardInterrupt:
        say(f'the estimate is in {folder}; "mechid report {folder}" makes its report')
        raise
    except UnwritableError:
        raise
    except Exception as error:
        illustration.give_up()
        what = " ".join(f"{type(error).__name__}: {error}".split())
        say(f'warning: no report was made ({what}); "mechid report {folder}" tries again')
        return []
