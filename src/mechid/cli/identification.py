"""An identification as commands run it: progress shown and noted down, results written and printed."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import typer

from mechid.analysis import RecordValidation, validate
from mechid.campaign import Campaign, load_campaign
from mechid.campaign.mechanism_text import write_mechanism
from mechid.cli.finished_fit import COMPLETED_NAME
from mechid.cli.journal import FILE_NAME, StageLines
from mechid.cli.progress_line import ProgressLine
from mechid.errors import FitError
from mechid.identification.computation.journal import Journal
from mechid.identification.computation.progress import Progress
from mechid.identification.diagnosis.suggestion import with_suggestions
from mechid.identification.identify import identify
from mechid.identification.output_error.inputs import campaign_digests
from mechid.identification.result.estimated_mechanism import signed
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import GRADE_WORDS, Grade
from mechid.identification.result.outcome import FitOutcome
from mechid.report import print_report, report_data, write_results
from mechid.report.pens import Pens
from mechid.report.results import MECHANISM_NAME, REPORT_NAME, estimated_text
from mechid.report.terminal import console_on

INTERRUPTED = 130
ESTIMATED_NAME = "mechanism_estimated.toml"
"""Of the estimated mechanism, where the campaign's own lies in the folder and keeps its name."""


def identify_into(
    campaign: Campaign,
    folder: Path,
    *,
    seed: int = 0,
    workers: int | None = None,
    truth: Mapping[str, float] | None = None,
    resume: bool = False,
    complete: bool = False,
) -> None:
    """Identify a campaign, leave the results in a folder, and print them.

    `truth` is that of a synthetic campaign; where it is given the report says so. With `resume` the last run in the
    folder's journal is taken up where it was stopped. With `complete` the mechanism gets what its records say it lacks,
    and is identified again.

    Raises
    ------
    FitError
        The fit did not succeed; the results are there all the same.
    typer.Exit
        It was interrupted, with its exit code; the results are those so far.
    """
    fit, journal = _followed(campaign, folder, seed, workers, resume)
    diagnosed: list[Path] = []
    if complete and fit.grade is not Grade.FAILED:
        campaign, fit, diagnosed = _completed(campaign, fit, folder, seed, workers)
    fit = with_suggestions(campaign, fit, workers or os.cpu_count() or 1, told=lambda line: typer.echo(line, err=True))
    with Pens() as pens:
        validation = validate(campaign, fit)
        is_own = (folder / MECHANISM_NAME).resolve() == campaign.mechanism_path.resolve()
        mechanism_name = ESTIMATED_NAME if is_own else MECHANISM_NAME
        fit = signed(fit, mechanism_name, estimated_text(fit, synthetic=truth is not None))
        data = report_data(fit, truth, synthetic=truth is not None, validation=validation)
        files = write_results(fit, data, folder, mechanism_name=mechanism_name, validation=validation)
        files += [journal, *diagnosed, *_report(data, campaign, fit, validation, folder, pens)]
    print_report(data, console_on(), files)
    if fit.outcome is FitOutcome.INTERRUPTED:
        typer.echo(f"mechid: interrupted; {folder} holds the best so far", err=True)
        raise typer.Exit(INTERRUPTED)
    if not fit.grade.good:
        raise FitError(_refusal(fit, folder))


def _completed(
    campaign: Campaign, fit: Fit, folder: Path, seed: int, workers: int | None
) -> tuple[Campaign, Fit, list[Path]]:
    """Diagnose a fit, and identify again with the mechanism that is proposed; the steps stay with the fit."""
    from mechid.identification.diagnosis.completion import identified_with
    from mechid.identification.diagnosis.diagnosis import diagnose
    from mechid.report.diagnosis import PROPOSED, diagnosis_data, write_diagnosis

    with ProgressLine(console_on(err=True)) as line:
        found = diagnose(campaign, fit, workers=workers, listener=line.tell)
        files = write_diagnosis(found, diagnosis_data(found), folder)
        if found.mechanism is None:
            return campaign, replace(fit, completed=()), files
        path = folder / COMPLETED_NAME
        write_mechanism(found.mechanism, path, PROPOSED)
        whole = load_campaign(campaign.path, mechanism_file=path)
        again = identified_with(whole, found, seed=seed, workers=workers, listener=line.tell)
    return whole, again, [path, *files]


def _refusal(fit: Fit, folder: Path) -> str:
    """Say why the values are not to be used as they are, and what to do next."""
    said = [f"{reason.text} Next: {reason.next_command}." for reason in fit.reasons[:1]]
    return " ".join([GRADE_WORDS[fit.grade], *said, f"{folder} holds what was reached"])


def _report(
    data: Mapping[str, Any],
    campaign: Campaign,
    fit: Fit,
    validation: Mapping[str, RecordValidation],
    folder: Path,
    pens: Pens,
) -> list[Path]:
    """Write the report; where that fails say so, since the estimate is on disk already."""
    typer.echo("making the report ...", err=True)
    try:
        from mechid.report.writing import write_report

        files = write_report(data, campaign, fit, validation, folder, pens)
        return [path for path in files if path.name != REPORT_NAME]
    except KeyboardInterrupt:
        typer.echo(f'the estimate is in {folder}; "mechid report {folder}" makes its report', err=True)
        raise
    except Exception as error:
        what = " ".join(f"{type(error).__name__}: {error}".split())
        typer.echo(f'warning: no report was made ({what}); "mechid report {folder}" tries again', err=True)
        return []


def _followed(campaign: Campaign, folder: Path, seed: int, workers: int | None, resume: bool) -> tuple[Fit, Path]:
    """Run the identification with its progress on stderr and in the journal."""
    path = folder / FILE_NAME
    inputs = {**campaign_digests(campaign), "seed": str(seed)}
    about = {"campaign": str(campaign.path.resolve()), "seed": seed, "mechid": version("mechid")}
    journal = Journal.opened(path, inputs, resume=resume, **about)
    if resume:
        typer.echo(f"{path}: {len(journal.known)} steps are there already", err=True)
    stages = StageLines(journal)
    with ProgressLine(console_on(err=True)) as line:

        def told(progress: Progress) -> None:
            line.tell(progress)
            stages.tell(progress)

        fit = identify(campaign, seed=seed, workers=workers, listener=told, journal=journal)
        stages.finish(fit)
    return fit, path
