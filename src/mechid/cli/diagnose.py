"""``mechid diagnose``: what the mechanism file lacks, as the records of a finished fit say it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from mechid.cli.scheduler import Scheduler, on_scheduler


def diagnose(
    fit: Annotated[Path, typer.Argument(metavar="FIT", help="Result folder of mechid identify, or its campaign.toml.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results; made where missing.")],
    campaign: Annotated[Path | None, typer.Option(help="Where FIT does not say it.")] = None,
    consider: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Look for this effect alone, or for all of its kind; may be repeated."),
    ] = None,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads; one per core without it.")] = None,
    scheduler: Scheduler = None,
) -> None:
    """Say which effects the mechanism file lacks, and propose a file that has them."""
    from mechid.cli.finished_fit import finished_fit
    from mechid.cli.progress_line import ProgressLine
    from mechid.holding import held
    from mechid.identification.diagnosis.diagnosis import diagnose as diagnosed
    from mechid.reports.diagnosis import diagnosis_data, print_diagnosis, write_diagnosis
    from mechid.reports.terminal import console_on

    finished = finished_fit(fit, campaign)
    asked = replace(finished.campaign, considered=tuple(consider)) if consider else finished.campaign
    with held(out):
        with on_scheduler(scheduler), ProgressLine(console_on(err=True)) as line:
            found = diagnosed(asked, finished.estimate, workers=workers, listener=line.tell)
        data = diagnosis_data(found)
        files = write_diagnosis(found, data, out)
        print_diagnosis(data, console_on(), files)
