"""``mechid design``: selection of the next records, their information, and rates with step loss."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mechid.cli.scheduler import Scheduler, on_scheduler


def design(
    campaign: Annotated[Path, typer.Argument(help="A campaign.toml or its folder; its records need no files.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results; made where missing.")],
    options: Annotated[
        Path | None,
        typer.Option("--design", metavar="design.toml", help="Candidates and limits, else beside CAMPAIGN."),
    ] = None,
    fit: Annotated[
        Path | None, typer.Option(metavar="DIR", help="A fit of the campaign: what to measure next.")
    ] = None,
    diagnosis: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="A diagnosis of that fit: the record that tells its rival effects apart."),
    ] = None,
    criterion: Annotated[str | None, typer.Option(help="D, A, E or the name of a parameter.")] = None,
    total_s: Annotated[float | None, typer.Option(min=0.0, help="Test time, what is between records included.")] = None,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads; one per core without it.")] = None,
    scheduler: Scheduler = None,
) -> None:
    """Choose the records of the next test, and rate step loss."""
    from mechid.campaign import load_campaign
    from mechid.cli.output import print_result, say
    from mechid.designs.diagnosis_file import read_diagnosed
    from mechid.designs.proposal import refuse_own_folder
    from mechid.designs.run import design as designed
    from mechid.errors import UsageError
    from mechid.locks import hold_folder

    loaded = load_campaign(campaign, read_records=False)
    refuse_own_folder(loaded.path, out)
    if diagnosis and not fit:
        raise UsageError(f"--diagnosis {diagnosis}: give --fit DIR too, the fit that was diagnosed")
    # Read before the fit is loaded, which takes longer.
    named = read_diagnosed(diagnosis) if diagnosis else None
    with hold_folder(out):
        with on_scheduler(scheduler):
            made = designed(
                loaded,
                options,
                fit=fit,
                diagnosis=named,
                criterion=criterion,
                total_s=total_s,
                workers=workers,
                say=say,
            )
        print_result(made, out)
