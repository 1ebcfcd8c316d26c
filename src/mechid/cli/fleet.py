"""``mechid fleet``: identification and joint evaluation of many campaigns."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mechid.cli.scheduler import Scheduler, on_scheduler


def fleet(
    sources: Annotated[
        list[Path],
        typer.Argument(metavar="DIR...", help="Campaign folders, result folders of identify, or fleet.toml."),
    ],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results; made where missing.")],
    seed: Annotated[int, typer.Option(min=0, help="Of each search; equal seeds give equal results.")] = 0,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads; one per core without it.")] = None,
    scheduler: Scheduler = None,
    complete: Annotated[
        bool, typer.Option("--complete", help="Add what the records say the mechanism files lack, and identify again.")
    ] = False,
) -> None:
    """Identify many campaigns, and say what differs, what changes and what stands off."""
    from mechid.cli.output import print_result, say
    from mechid.errors import FitError
    from mechid.fleets.run import fleet as together
    from mechid.locks import hold_folder

    with hold_folder(out):
        with on_scheduler(scheduler):
            made = together(*sources, out=out, seed=seed, workers=workers, complete=complete, say=say)
        print_result(made, out)
    if made.failed:
        summary = f"{len(made.failed)} of {len(made.asked.members)} campaigns have no estimate to use"
        raise FitError(f"fleet: {summary}: {', '.join(made.failed)}; {out} holds what was reached, and why")
