"""``mechid kernel``: equations of a mechanism, and the code generated from them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def kernel(
    mechanism: Annotated[
        Path | None, typer.Argument(metavar="[MECHANISM]", help="mechanism.toml; without it the paper's.")
    ] = None,
    source: Annotated[bool, typer.Option("--source", help="The generated source instead.")] = False,
    latex: Annotated[bool, typer.Option("--latex", help="The equations as LaTeX.")] = False,
    lanes: Annotated[int, typer.Option(min=0, help="Parameters whose sensitivities ride along.")] = 0,
) -> None:
    """Print a mechanism's equations, or their compiled source."""
    from mechid.campaign import catalogue_mechanism, load_mechanism
    from mechid.cli.kernel_notice import prepare_kernel
    from mechid.errors import UsageError
    from mechid.kernel.generated_text import equations, kernel_source

    if source and latex:
        raise UsageError("--source, --latex: give one of them")
    read = load_mechanism(mechanism) if mechanism else catalogue_mechanism()
    text = kernel_source(read, sensitivities=lanes) if source else equations(read, latex=latex)
    typer.echo(text, nl=False)
    typer.echo(f"its source: {prepare_kernel(read.plant, lanes).path}", err=True)
