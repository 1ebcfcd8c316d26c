"""``mechid design``: which records to take next, what they would tell, and which rates lose steps."""

from __future__ import annotations

import os
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
    from mechid.cli.finished_fit import finished_fit
    from mechid.designs.design import make_design
    from mechid.designs.design_file import beside, read_design_file
    from mechid.designs.diagnosis_file import read_diagnosed
    from mechid.designs.rivals import Group, rival_groups
    from mechid.errors import UsageError
    from mechid.holding import held
    from mechid.identification.refit.reopened import reopened
    from mechid.reports.design import print_design, refuse_own_folder, write_design
    from mechid.reports.terminal import console_on

    def tell(line: str) -> None:
        typer.echo(line, err=True)

    count = workers or os.cpu_count() or 1
    loaded = load_campaign(campaign, read_records=False)
    refuse_own_folder(loaded.path, out)
    asked = (read_design_file(options) if options else beside(loaded.path)).asking(criterion, total_s)
    if diagnosis and not fit:
        raise UsageError(f"--diagnosis {diagnosis}: give --fit DIR too, the fit that was diagnosed")
    diagnosed = read_diagnosed(diagnosis) if diagnosis else None
    if diagnosed and not diagnosed.groups:
        tell(
            f"{diagnosed.path}: names no rival effects, so there is nothing to tell apart; the design is the usual one"
        )

    with held(out):
        with on_scheduler(scheduler):
            optimum, rivals = None, tuple[Group, ...]()
            if fit:
                found = finished_fit(fit, loaded.path)
                optimum = reopened(found.campaign, found.estimate, workers=count)
                if diagnosed:
                    rivals = rival_groups(found.campaign, found.estimate, diagnosed, workers=count, told=tell)
            made = make_design(loaded, asked, fit=optimum, rivals=rivals, workers=count, told=tell)
        data, files = write_design(made, out)
        print_design(data, console_on(), files)
