"""Identification in a command, with progress, printed results and exit code."""

from __future__ import annotations

from pathlib import Path

import typer

from mechid.campaign import Campaign
from mechid.cli.output import say, show_progress
from mechid.cli.termination import INTERRUPTED, advise, say_interrupted
from mechid.errors import FitError
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import FitOutcome, grade_words
from mechid.identification.run import IdentifyRun
from mechid.ink.console import console_on
from mechid.reports.document import PRESENTER
from mechid.reports.into_folder import DEFAULT_RUN, Audience, identify_into_folder


def identify_into(campaign: Campaign, folder: Path, run: IdentifyRun = DEFAULT_RUN, *, docx: bool = False) -> None:
    """Identify a campaign, write the results to a folder, and print them.

    Raises
    ------
    FitError
        The fit did not succeed; the results are written nevertheless.
    typer.Exit
        The fit was interrupted; the results so far are written.
    """
    advise(f"what was worked out is in {folder}: mechid identify with --resume goes on")
    made = identify_into_folder(campaign, folder, Audience(followed=show_progress, say=say), run, docx=docx)
    PRESENTER.print(made.data, console_on(), made.files)
    if made.fit.outcome is FitOutcome.INTERRUPTED:
        say_interrupted(f"mechid: interrupted; {folder} holds the best so far")
        raise typer.Exit(INTERRUPTED)
    if not made.fit.grade.good:
        raise FitError(_refusal(made.fit, folder))


def _refusal(fit: Fit, folder: Path) -> str:
    """Explain why the values should not be used, and what to do next."""
    reasons = [f"{reason.text} Next: {reason.next_command}." for reason in fit.reasons[:1]]
    return " ".join([grade_words(fit.grade, fit.outcome), *reasons, f"{folder} holds what was reached"])
