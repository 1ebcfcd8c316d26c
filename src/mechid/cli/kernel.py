"""``mechid kernel``: the equations of a mechanism, and the code made from them."""

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
    from mechid.campaign import catalogue_mechanism, read_mechanism
    from mechid.cli.kernel_notice import prepare_kernel
    from mechid.errors import UsageError
    from mechid.kernel.equation_text import equations_latex, equations_text

    if source and latex:
        raise UsageError("--source, --latex: give one of them")
    plant = (read_mechanism(mechanism) if mechanism else catalogue_mechanism()).plant
    if not source:
        typer.echo(equations_latex(plant) if latex else equations_text(plant), nl=False)
    compiled = prepare_kernel(plant, lanes)
    if source:
        typer.echo(compiled.path.read_text(encoding="utf-8"), nl=False)
    typer.echo(f"its source: {compiled.path}", err=True)
