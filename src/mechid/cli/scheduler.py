"""Option ``--scheduler`` of commands whose work can be distributed to other machines."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Annotated

import typer

Scheduler = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS", help="Dask scheduler whose workers do the work, as tcp://host:8786."),
]


def on_scheduler(address: str | None) -> AbstractContextManager[None]:
    """Return a context in which the workers of a scheduler execute mapped work; None uses this process."""
    from mechid.identification.computation.workforce import working_on_scheduler

    return working_on_scheduler(address, lambda line: typer.echo(line, err=True))
