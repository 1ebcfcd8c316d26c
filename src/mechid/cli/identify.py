"""``mechid identify``: estimation of the mechanism's parameters from records."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mechid.cli.docx_option import Docx
from mechid.cli.scheduler import Scheduler, on_scheduler


def identify(
    campaign: Annotated[Path, typer.Argument(metavar="CAMPAIGN", help="campaign.toml, or its folder.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results; made where missing.")],
    seed: Annotated[int, typer.Option(min=0, help="Of the search; equal seeds give equal results.")] = 0,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads; one per core without it.")] = None,
    scheduler: Scheduler = None,
    complete: Annotated[
        bool, typer.Option("--complete", help="Add what the records say the mechanism file lacks, and identify again.")
    ] = False,
    docx: Docx = False,
    resume: Annotated[bool, typer.Option("--resume", help="Go on where the last run in DIR was stopped.")] = False,
) -> None:
    """Estimate the free parameters, each with its uncertainty."""
    from mechid.campaign import load_campaign
    from mechid.cli.identification import identify_into
    from mechid.cli.kernel_notice import prepare_kernels
    from mechid.identification.run import IdentifyRun
    from mechid.ink.docx_file import refuse_without_docx
    from mechid.locks import hold_folder

    if docx:
        refuse_without_docx()
    loaded = load_campaign(campaign)
    with hold_folder(out):
        prepare_kernels(loaded)
        with on_scheduler(scheduler):
            run = IdentifyRun(seed=seed, workers=workers, complete=complete, resume=resume)
            identify_into(loaded, out, run, docx=docx)
