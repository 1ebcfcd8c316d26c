"""``mechid diagnose``: effects missing in the mechanism file, according to the records of a fit."""

from __future__ import annotations

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
    from mechid.cli.output import print_result, show_progress
    from mechid.diagnoses.run import diagnose as diagnosed
    from mechid.fits.load import load_fit
    from mechid.locks import hold_folder

    finished = load_fit(fit, campaign)
    with hold_folder(out):
        with on_scheduler(scheduler), show_progress() as listener:
            found = diagnosed(finished, consider=consider or (), workers=workers, listener=listener)
        print_result(found, out)
