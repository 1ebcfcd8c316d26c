"""``mechid budget``: from an estimate to the line of sight."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mechid.cli.scheduler import Scheduler, on_scheduler


def budget(
    file: Annotated[Path, typer.Argument(metavar="BUDGET.toml", help="What flies, on what, and how.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results; made where missing.")],
    workers: Annotated[int, typer.Option(min=1, help="Threads.")] = 1,
    scheduler: Scheduler = None,
) -> None:
    """Predict the line of sight's error against requirements."""
    from mechid.budgets.budget import make_budget
    from mechid.budgets.budget_file import read_budget_file
    from mechid.budgets.hand_off import write_budget
    from mechid.budgets.numbers import budget_data
    from mechid.holding import held
    from mechid.reports.budget.terminal import print_budget
    from mechid.reports.budget.writing import write_budget_report
    from mechid.reports.terminal import console_on

    asked = read_budget_file(file)
    with held(out), on_scheduler(scheduler):
        made = make_budget(asked, workers, lambda line: typer.echo(line, err=True))
        data = budget_data(made)
        files = write_budget(made, out, data)
        print_budget(data, console_on(), [*files, *write_budget_report(data, out)])
