"""``mechid fleet``: many campaigns, and what they say together."""

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
    from mechid.errors import FitError
    from mechid.fleets.fleet import make_fleet
    from mechid.fleets.fleet_file import read_members
    from mechid.fleets.hand_off import write_fleet
    from mechid.fleets.numbers import fleet_data
    from mechid.holding import held
    from mechid.reports.fleet.terminal import print_fleet
    from mechid.reports.fleet.writing import write_fleet_report
    from mechid.reports.terminal import console_on

    asked = read_members(sources)
    with held(out):
        with on_scheduler(scheduler):
            made = make_fleet(asked, out, seed=seed, workers=workers, complete=complete, told=_say)
        data = fleet_data(made, out)
        print_fleet(data, console_on(), [*write_fleet(data, out), *write_fleet_report(data, out)])
    if made.failed:
        of = f"{len(made.failed)} of {len(asked.members)} campaigns have no estimate to use"
        raise FitError(f"fleet: {of}: {', '.join(made.failed)}; {out} holds what was reached, and why")


def _say(line: str) -> None:
    typer.echo(line, err=True)
