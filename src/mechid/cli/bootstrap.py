"""``mechid bootstrap``: the scatter of estimates from records simulated again and again."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mechid.cli.scheduler import Scheduler, on_scheduler

if TYPE_CHECKING:
    from mechid.identification.refit.bootstrap import Draw

JOURNAL_NAME = "bootstrap.jsonl"


def bootstrap(
    fit: Annotated[Path, typer.Argument(metavar="FIT", help="Result folder of mechid identify, or its campaign.toml.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results; made where missing.")],
    draws: Annotated[int, typer.Option(min=2, help="How many; more can be added with --resume.")] = 200,
    campaign: Annotated[Path | None, typer.Option(help="Where FIT does not say it.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the noise.")] = 0,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads; one per core without it.")] = None,
    scheduler: Scheduler = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on where the last run in DIR was stopped.")] = False,
) -> None:
    """Refit simulated records, and see how estimates scatter."""
    from mechid.cli.finished_fit import finished_fit
    from mechid.cli.progress_line import ProgressLine
    from mechid.holding import held
    from mechid.identification.computation.journal import Journal
    from mechid.identification.computation.parallel import one_core_algebra
    from mechid.identification.computation.progress import Progress
    from mechid.identification.refit.bootstrap import bootstrap as bootstrapped
    from mechid.identification.refit.reopened import reopened
    from mechid.reports.bootstrap import bootstrap_data, print_bootstrap, write_bootstrap
    from mechid.reports.terminal import console_on

    found, count = finished_fit(fit, campaign), workers or os.cpu_count() or 1
    began, ended = time.perf_counter(), 0
    with held(out):
        with one_core_algebra(), on_scheduler(scheduler), ProgressLine(console_on(err=True)) as line:
            optimum = reopened(found.campaign, found.estimate, workers=count)

            def told(draw: Draw) -> None:
                nonlocal ended
                ended += 1
                where = f"{ended} of {draws} draws, number {draw.number} {draw.outcome.code.replace('_', ' ')}"
                line.tell(Progress(1, 1, "bootstrap", where, draw.cost, time.perf_counter() - began))

            journal = Journal.opened(out / JOURNAL_NAME, found.inputs, resume=resume)
            done = bootstrapped(optimum, draws, seed=seed, workers=count, journal=journal, told=told)
        data = bootstrap_data(done, seed)
        files = write_bootstrap(data, out)
        print_bootstrap(data, console_on(), files)
