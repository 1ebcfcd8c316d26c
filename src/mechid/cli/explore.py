"""``mechid explore``: local page for changing parameters and following fits."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def explore(
    campaign: Annotated[Path, typer.Argument(metavar="CAMPAIGN", help="campaign.toml, or its folder.")],
    fit: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Result folder of mechid identify; without it the campaign's own folder."),
    ] = None,
    diagnosis: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Result folder of mechid diagnose: a switch for each effect that it names."),
    ] = None,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Of the page; any that is free without it.")] = 0,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads of a fit; one per core without it.")] = None,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in a browser.")] = True,
) -> None:
    """Turn parameters in the browser and watch model and fit."""
    from mechid.cli.kernel_notice import prepare_kernels
    from mechid.web.run import load_source, serve

    source = load_source(campaign, fit=fit, diagnosis=diagnosis, workers=workers, needed=prepare_kernels)
    serve(source, port, browser=browser, ready=_ready)


def _ready(address: str) -> None:
    typer.echo(f"{address}  (this machine alone; Ctrl-C ends it)")
