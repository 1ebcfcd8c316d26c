"""``mechid profile``: the likelihood's own shape over one parameter after another."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mechid.cli.scheduler import Scheduler, on_scheduler

if TYPE_CHECKING:
    from mechid.identification.refit.profile import Point

JOURNAL_NAME = "profile.jsonl"


def profile(
    fit: Annotated[Path, typer.Argument(metavar="FIT", help="Result folder of mechid identify, or its campaign.toml.")],
    parameter: Annotated[list[str], typer.Option(metavar="NAME", help="Dotted name; may be repeated.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results; made where missing.")],
    campaign: Annotated[Path | None, typer.Option(help="Where FIT does not say it.")] = None,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads; one per core without it.")] = None,
    scheduler: Scheduler = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on where the last run in DIR was stopped.")] = False,
) -> None:
    """Profile the likelihood over a parameter, all others refitted."""
    from mechid.cli.finished_fit import finished_fit
    from mechid.cli.progress_line import ProgressLine
    from mechid.holding import held
    from mechid.identification.computation.journal import Journal
    from mechid.identification.computation.parallel import one_core_algebra
    from mechid.identification.computation.progress import Progress
    from mechid.identification.refit.profile import profiles
    from mechid.identification.refit.reopened import reopened
    from mechid.reports.profile import print_profiles, profile_data, write_profiles
    from mechid.reports.terminal import console_on

    found, count = finished_fit(fit, campaign), workers or os.cpu_count() or 1
    began = time.perf_counter()
    with held(out):
        with one_core_algebra(), on_scheduler(scheduler), ProgressLine(console_on(err=True)) as line:
            optimum = reopened(found.campaign, found.estimate, workers=count)

            def told(name: str, point: Point) -> None:
                where = f"{name} at {point.value:.9g}, cost rises by {point.rise:.3g}"
                line.tell(Progress(1, 1, "profile", where, None, time.perf_counter() - began))

            for name in parameter:
                optimum.one(name)
            journal = Journal.opened(out / JOURNAL_NAME, found.inputs, resume=resume)
            done = profiles(optimum, list(dict.fromkeys(parameter)), workers=count, journal=journal, told=told)
        data = profile_data(done)
        files = write_profiles(data, out)
        print_profiles(data, console_on(), files)
