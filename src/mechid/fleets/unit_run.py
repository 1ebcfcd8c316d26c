"""Run of one campaign of a fleet: identification into its own folder, or reuse of a finished fit."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from mechid.campaign import Campaign, load_campaign
from mechid.campaign.campaign_file import FILE_NAME as CAMPAIGN_NAME
from mechid.errors import MechidError
from mechid.fleets.members import Member
from mechid.fleets.resume_check import can_resume, changed_inputs
from mechid.identification.computation.progress import Listener, Progress, Tell
from mechid.identification.result.grade import FitOutcome
from mechid.identification.run import IdentifyRun
from mechid.locks import hold_folder
from mechid.reports.into_folder import Audience, identify_into_folder


def ignore(line: str) -> None:
    """Ignore a line of progress."""
    del line


class EstimateOrigin(StrEnum):
    """Origin of a campaign's estimate; `ORIGIN_WORDS` has the words."""

    IDENTIFIED = "identified"
    RESUMED = "resumed"
    CHANGED = "changed"
    TAKEN_UP = "taken_up"
    GIVEN = "given"
    NONE = "none"


ORIGIN_WORDS = {
    EstimateOrigin.IDENTIFIED: "identified",
    EstimateOrigin.RESUMED: "resumed",
    EstimateOrigin.CHANGED: "identified anew",
    EstimateOrigin.TAKEN_UP: "taken up",
    EstimateOrigin.GIVEN: "given as a finished fit",
    EstimateOrigin.NONE: "no estimate",
}


@dataclass(frozen=True, kw_only=True)
class UnitTask:
    """Campaign to identify, as plain values, so that any process can run it.

    Parameters
    ----------
    label, source, folder : str
        Name in messages; path of the campaign or of a finished fit; folder for results.
    seed : int
    workers : int or None
        Number of threads; None takes one per core.
    complete : bool
        Add the effects that the records show to be missing from the mechanism file.
    hold : str
        Token of the fleet's own lock on its folder.
    """

    label: str
    source: str
    folder: str
    seed: int
    workers: int | None
    complete: bool
    hold: str


@dataclass(frozen=True, kw_only=True)
class UnitRun:
    """Origin of a campaign's estimate.

    Attributes
    ----------
    how : EstimateOrigin
    folder : str
        Folder of estimate.json.
    said : str
        Inputs that have changed since the last identification, or why there is no estimate.
    seconds : float
        Wall time of this run.
    """

    how: EstimateOrigin
    folder: str
    said: str = ""
    seconds: float = 0.0

    @property
    def words(self) -> str:
        """Summary in one line."""
        return f"{ORIGIN_WORDS[self.how]}{f' ({self.said})' if self.said else ''}, {self.seconds:.1f} s"


def task_of(member: Member, out: Path, seed: int, workers: int | None, *, complete: bool, hold: str) -> UnitTask:
    """Return the task of a member of a fleet, with results in a folder within `out`."""
    return UnitTask(
        label=member.label,
        source=str(member.source.resolve()),
        folder=str((out / member.folder_name).resolve()),
        seed=seed,
        workers=workers,
        complete=complete,
        hold=hold,
    )


def run_unit(task: UnitTask, say: Tell = ignore) -> UnitRun:
    """Identify a campaign, or reuse a finished fit; a failure is reported in the result.

    Raises
    ------
    KeyboardInterrupt
        The run was interrupted; the best result so far is in the folder, and the next run resumes from it.
    """
    began = time.perf_counter()
    try:
        how, folder, said = _obtain_estimate(task, say)
    except Exception as error:
        # A failure of one campaign, of whatever kind, must not stop the others.
        kind = "" if isinstance(error, MechidError) else f"unexpected error, {type(error).__name__}: "
        how, folder, said = EstimateOrigin.NONE, task.folder, kind + " ".join(str(error).split())
    return UnitRun(how=how, folder=folder, said=said, seconds=time.perf_counter() - began)


def _obtain_estimate(task: UnitTask, say: Tell) -> tuple[EstimateOrigin, str, str]:
    """Return the origin of an estimate, its folder, and the changed inputs."""
    source, folder = Path(task.source), Path(task.folder)
    if source.is_dir() and not (source / CAMPAIGN_NAME).is_file():
        return EstimateOrigin.GIVEN, task.source, ""
    campaign = load_campaign(source)
    own = source if source.is_dir() else source.parent
    changed = None
    # The fleet's own result comes first, so that repeated runs give the same folder.
    for place, how in ((folder, EstimateOrigin.TAKEN_UP), (own, EstimateOrigin.GIVEN)):
        since = changed_inputs(campaign, place, task.seed, complete=task.complete)
        if since == ():
            return how, str(place), ""
        changed = since if place == folder else changed
    # The fleet holds the folder above; its token admits a lock within.
    with hold_folder(folder, within=task.hold):
        # Read first: the identification writes to the same journal.
        resumed = can_resume(campaign, folder, task.seed)
        _identify(campaign, task, say, resume=resumed)
    if changed is not None:
        return EstimateOrigin.CHANGED, task.folder, f"changed: {', '.join(changed)}"
    return EstimateOrigin.RESUMED if resumed else EstimateOrigin.IDENTIFIED, task.folder, ""


def _identify(campaign: Campaign, task: UnitTask, say: Tell, *, resume: bool) -> None:
    def say_of_unit(line: str) -> None:
        say(f"{task.label}: {line}")

    @contextmanager
    def follow_stages() -> Iterator[Listener]:
        yield _stages(say_of_unit)

    made = identify_into_folder(
        campaign,
        Path(task.folder),
        Audience(followed=follow_stages, say=say_of_unit),
        IdentifyRun(seed=task.seed, workers=task.workers, complete=task.complete, resume=resume),
    )
    if made.fit.outcome is FitOutcome.INTERRUPTED:
        # Ctrl-C in one campaign stops the whole fleet.
        raise KeyboardInterrupt


def _stages(say: Tell) -> Listener:
    """Return a listener that reports each stage as it begins."""
    heard = [""]

    def on_progress(progress: Progress) -> None:
        if progress.stage != heard[0]:
            heard[0] = progress.stage
            say(f"stage {progress.number} of {progress.total}: {progress.stage}, {progress.elapsed_s:.1f} s")

    return on_progress
