"""``mechid explore``: a local page on which parameters are turned and fits watched."""

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
    from mechid.campaign import load_campaign
    from mechid.campaign.bench import TRUTH_NAME
    from mechid.cli.kernel_notice import prepare_kernels
    from mechid.identification.result.estimate_file import FILE_NAME
    from mechid.identification.result.journal_file import FILE_NAME as JOURNAL_NAME
    from mechid.interface.finished_fit import completed_file
    from mechid.web import Explorer, Source, read_diagnosed, read_estimated

    folder = fit or (campaign if campaign.is_dir() else campaign.parent)
    completed = completed_file(folder) if (folder / FILE_NAME).is_file() else None
    loaded = load_campaign(campaign, mechanism_file=completed)
    prepare_kernels(loaded)
    journal = folder / JOURNAL_NAME
    has_estimate = (folder / FILE_NAME).is_file() or (fit is not None and not journal.is_file())
    estimate = read_estimated(folder / FILE_NAME, loaded) if has_estimate else None
    diagnosed = None
    if diagnosis is not None:
        loaded, diagnosed = read_diagnosed(diagnosis, loaded, estimate)
        prepare_kernels(loaded)
    followed = journal if diagnosis is None else None  # the fit that was diagnosed has ended
    synthetic = (loaded.path.parent / TRUTH_NAME).is_file()
    explorer = Explorer(Source(loaded, estimate, workers, followed, synthetic, diagnosed), port)
    explorer.serve(opens_browser=browser, ready=_ready)


def _ready(address: str) -> None:
    typer.echo(f"{address}  (this machine alone; Ctrl-C ends it)")
