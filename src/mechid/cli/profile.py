"""``mechid profile``: likelihood profiles of single parameters."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mechid.cli.scheduler import Scheduler, on_scheduler

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
    from mechid.cli.output import print_result, show_progress
    from mechid.cli.termination import advise
    from mechid.fits.load import load_fit
    from mechid.locks import hold_folder
    from mechid.profiles.run import profile as profiled

    found = load_fit(fit, campaign)
    advise(f"what was worked out is in {out}: the same command with --resume goes on")
    with hold_folder(out):
        with on_scheduler(scheduler), show_progress() as listener:
            done = profiled(
                found,
                parameter,
                workers=workers,
                listener=listener,
                journal=out / JOURNAL_NAME,
                resume=resume,
            )
        print_result(done, out)
