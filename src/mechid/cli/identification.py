"""An identification as commands run it: progress shown, results printed, and its exit code."""

from __future__ import annotations

from pathlib import Path

import typer

from mechid.campaign import Campaign
from mechid.cli.ending import INTERRUPTED, advise, say_interrupted
from mechid.cli.printed import followed, say
from mechid.errors import FitError
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import FitOutcome, grade_words
from mechid.identification.run import IdentifyRun
from mechid.ink.console import console_on
from mechid.reports.document import PRESENTER
from mechid.reports.into_folder import DEFAULT_RUN, Audience, identify_into_folder


def identify_into(campaign: Campaign, folder: Path, run: IdentifyRun = DEFAULT_RUN) -> None:
    """Identify a campaign, leave the results in a folder, and print them.

    Raises
    ------
    FitError
        The fit did not succeed; the results are there all the same.
    typer.Exit
        It was interrupted, with its exit code; the results are those so far.
    """
    advise(f"what was worked out is in {folder}: mechid identify with --resume goes on")
    made = identify_into_folder(campaign, folder, Audience(followed=followed, say=say), run)
    PRESENTER.print(made.data, console_on(), made.files)
    if made.fit.outcome is FitOutcome.INTERRUPTED:
        say_interrupted(f"mechid: interrupted; {folder} holds the best so far")
        raise typer.Exit(INTERRUPTED)
    if not made.fit.grade.good:
        raise FitError(_refusal(made.fit, folder))


def _refusal(fit: Fit, folder: Path) -> str:
    """Say why the values are not to be used as they are, and what to do next."""
    said = [f"{reason.text} Next: {reason.next_command}." for reason in fit.reasons[:1]]
    return " ".join([grade_words(fit.grade, fit.outcome), *said, f"{folder} holds what was reached"])
