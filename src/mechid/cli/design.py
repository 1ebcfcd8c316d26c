"""``mechid design``: which records to take next, what they would tell, and which rates lose steps."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer


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
    criterion: Annotated[str | None, typer.Option(help="D, A, E or the name of a parameter.")] = None,
    total_s: Annotated[float | None, typer.Option(min=0.0, help="Test time, what is between records included.")] = None,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads; one per core without it.")] = None,
) -> None:
    """Design the next test: the records that tell most in the time there is."""
    from mechid.campaign import load_campaign
    from mechid.cli.finished_fit import finished_fit
    from mechid.design.design import make_design
    from mechid.design.design_file import beside, read_design_file
    from mechid.identification.refit.reopened import reopened
    from mechid.report.design import print_design, refuse_own_folder, write_design
    from mechid.report.terminal import console_on

    count = workers or os.cpu_count() or 1
    loaded = load_campaign(campaign, read_records=False)
    refuse_own_folder(loaded.path, out)
    asked = (read_design_file(options) if options else beside(loaded.path)).asking(criterion, total_s)
    optimum = None
    if fit:
        found = finished_fit(fit, loaded.path)
        optimum = reopened(found.campaign, found.estimate, workers=count)
    made = make_design(loaded, asked, fit=optimum, workers=count, told=lambda line: typer.echo(line, err=True))
    data, files = write_design(made, out)
    print_design(data, console_on(), files)
