"""``mechid budget``: prediction of the line-of-sight error from an estimate."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mechid.cli.docx_option import Docx
from mechid.cli.scheduler import Scheduler, on_scheduler


def budget(
    file: Annotated[Path, typer.Argument(metavar="BUDGET.toml", help="What flies, on what, and how.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results; made where missing.")],
    workers: Annotated[int, typer.Option(min=1, help="Threads.")] = 1,
    scheduler: Scheduler = None,
    docx: Docx = False,
    strict: Annotated[bool, typer.Option("--strict", help="Exit with 5 where a requirement is not met.")] = False,
) -> None:
    """Predict the line of sight's error and the emission at the interface against requirements."""
    from mechid.budgets.run import budget as budgeted
    from mechid.budgets.verdict import unmet
    from mechid.cli.output import print_result, say
    from mechid.errors import FitError
    from mechid.ink.docx_file import refuse_without_docx
    from mechid.locks import hold_folder

    if docx:
        refuse_without_docx()
    with hold_folder(out), on_scheduler(scheduler):
        made = budgeted(file, workers=workers, say=say)
        print_result(made, out, docx=docx)
    if strict and (left := unmet(made.to_dict())):
        raise FitError(f"not shown to be met: {', '.join(left)}; see {out / 'budget.md'}")
