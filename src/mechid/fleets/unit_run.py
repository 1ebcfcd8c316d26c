"""One campaign of a fleet, identified into its own folder or taken up from there: a task of plain values."""

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
from mechid.fleets.finished import can_resume, changed_since
from mechid.fleets.members import Member
from mechid.holding import hold_folder
from mechid.identification.computation.progress import Listener, Progress, Tell
from mechid.identification.result.grade import FitOutcome
from mechid.identification.run import IdentifyRun
from mechid.reports.into_folder import Audience, identify_into_folder


def silent(line: str) -> None:
    """Listen to nothing."""
    del line


class How(StrEnum):
    """How the estimate of a campaign came about; `HOW_WORDS` say it."""

    IDENTIFIED = "identified"
    RESUMED = "resumed"
    CHANGED = "changed"
    TAKEN_UP = "taken_up"
    GIVEN = "given"
    NONE = "none"


HOW_WORDS = {
    How.IDENTIFIED: "identified",
    How.RESUMED: "resumed",
    How.CHANGED: "identified anew",
    How.TAKEN_UP: "taken up",
    How.GIVEN: "given as a finished fit",
    How.NONE: "no estimate",
}


@dataclass(frozen=True, kw_only=True)
class UnitTask:
    """A campaign to be identified, as plain values, so that any process can do it.

    Parameters
    ----------
    label, source, folder : str
        By which it is shown; where the campaign, or the finished fit, is; where the results go.
    seed : int
    workers : int or None
        Threads; None takes one per core.
    complete : bool
        Add what the records say the mechanism file lacks.
    hold : str
        Token of the fleet's own hold of its folder.
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
    """How the estimate of a campaign came about.

    Attributes
    ----------
    how : How
    folder : str
        That holds estimate.json.
    said : str
        What has changed since it was last identified, or why there is no estimate.
    seconds : float
        Wall time of it here.
    """

    how: How
    folder: str
    said: str = ""
    seconds: float = 0.0

    @property
    def words(self) -> str:
        """The same in a line."""
        return f"{HOW_WORDS[self.how]}{f' ({self.said})' if self.said else ''}, {self.seconds:.1f} s"


def task_of(member: Member, out: Path, seed: int, workers: int | None, *, complete: bool, hold: str) -> UnitTask:
    """Return the task of a member of a fleet, its results in a folder within `out`."""
    return UnitTask(
        label=member.label,
        source=str(member.source.resolve()),
        folder=str((out / member.folder_name).resolve()),
        seed=seed,
        workers=workers,
        complete=complete,
        hold=hold,
    )


def run_unit(task: UnitTask, say: Tell = silent) -> UnitRun:
    """Identify a campaign, or take up what is finished; what fails is said in the result.

    Raises
    ------
    KeyboardInterrupt
        It was interrupted; the best so far is in the folder, and the next run goes on from there.
    """
    began = time.perf_counter()
    try:
        how, folder, said = _done(task, say)
    except Exception as error:  # whatever is wrong with one campaign, the others go on
        kind = "" if isinstance(error, MechidError) else f"unexpected error, {type(error).__name__}: "
        how, folder, said = How.NONE, task.folder, kind + " ".join(str(error).split())
    return UnitRun(how=how, folder=folder, said=said, seconds=time.perf_counter() - began)


def _done(task: UnitTask, say: Tell) -> tuple[How, str, str]:
    """Return how an estimate came about, its folder, and what has changed."""
    source, folder = Path(task.source), Path(task.folder)
    if source.is_dir() and not (source / CAMPAIGN_NAME).is_file():
        return How.GIVEN, task.source, ""
    campaign = load_campaign(source)
    own = source if source.is_dir() else source.parent
    changed = None
    for place, how in ((folder, How.TAKEN_UP), (own, How.GIVEN)):
        since = changed_since(campaign, place, task.seed, complete=task.complete)
        if since == ():
            return how, str(place), ""
        changed = since if place == folder else changed
    with hold_folder(folder, within=task.hold):
        resumed = can_resume(campaign, folder, task.seed)
        _identify(campaign, task, say, resume=resumed)
    if changed is not None:
        return How.CHANGED, task.folder, f"changed: {', '.join(changed)}"
    return How.RESUMED if resumed else How.IDENTIFIED, task.folder, ""


def _identify(campaign: Campaign, task: UnitTask, say: Tell, *, resume: bool) -> None:
    def say_of_unit(line: str) -> None:
        say(f"{task.label}: {line}")

    @contextmanager
    def followed() -> Iterator[Listener]:
        yield _stages(say_of_unit)

    made = identify_into_folder(
        campaign,
        Path(task.folder),
        Audience(followed=followed, say=say_of_unit),
        IdentifyRun(seed=task.seed, workers=task.workers, complete=task.complete, resume=resume),
    )
    if made.fit.outcome is FitOutcome.INTERRUPTED:
        raise KeyboardInterrupt


def _stages(say: Tell) -> Listener:
    """Return a listener that says each stage as it begins."""
    heard = [""]

    def listen(progress: Progress) -> None:
        if progress.stage != heard[0]:
            heard[0] = progress.stage
            say(f"stage {progress.number} of {progress.total}: {progress.stage}, {progress.elapsed_s:.1f} s")

    return listen
