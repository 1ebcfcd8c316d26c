"""``mechid bootstrap``: scatter of estimates from repeatedly simulated records."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mechid.cli.scheduler import Scheduler, on_scheduler

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
    from mechid.bootstraps.run import bootstrap as bootstrapped
    from mechid.cli.output import print_result, show_progress
    from mechid.cli.termination import advise
    from mechid.fits.load import load_fit
    from mechid.locks import hold_folder

    found = load_fit(fit, campaign)
    advise(f"what was worked out is in {out}: the same command with --resume goes on")
    with hold_folder(out):
        with on_scheduler(scheduler), show_progress() as listener:
            done = bootstrapped(
                found,
                draws,
                seed=seed,
                workers=workers,
                listener=listener,
                journal=out / JOURNAL_NAME,
                resume=resume,
            )
        print_result(done, out)
