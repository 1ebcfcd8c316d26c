"""``mechid demo``: synthetic bench with its full identification."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def demo(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for campaign and results.")] = Path("mechid-demo"),
    seed: Annotated[int, typer.Option(min=0, help="Of the bench's noise and of the search.")] = 0,
) -> None:
    """Make a synthetic bench and identify it from catalogue values."""
    from mechid.budgets.example import BUDGET_NAME
    from mechid.campaign import catalogue_mechanism
    from mechid.campaign.bench import TRUTH, refuse_measured_campaign
    from mechid.cli.identification import identify_into
    from mechid.cli.kernel_notice import prepare_kernel
    from mechid.demos.run import make_bench
    from mechid.identification.run import IdentifyRun
    from mechid.locks import hold_folder
    from mechid.reports.files import PAGE_NAME

    refuse_measured_campaign(out)
    with hold_folder(out):
        prepare_kernel(catalogue_mechanism().plant)
        typer.echo(f"making a synthetic bench in {out}: nothing of it was measured", err=True)
        identify_into(make_bench(out, seed), out, IdentifyRun(seed=seed, truth=TRUTH))
    typer.echo(f"next: open {out / PAGE_NAME}, and mechid budget {out / BUDGET_NAME} --out {out / 'budget'}")
