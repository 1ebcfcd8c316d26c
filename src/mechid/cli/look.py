"""``mechid look``: examination of records without a model."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def look(
    records: Annotated[
        list[Path],
        typer.Argument(metavar="RECORD...", help="Measured files, or campaign.toml: records with their commands."),
    ],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for page, numbers and CSV; made where missing.")],
    sample_rate_hz: Annotated[
        float | None, typer.Option(min=1e-9, help="Of files without a time column or clock.")
    ] = None,
    column: Annotated[
        list[str] | None,
        typer.Option(help="Column, by name or index from 0; may be given again. All without it."),
    ] = None,
    quantity: Annotated[str | None, typer.Option(help="What the column is, as torque or rotor_rate.")] = None,
    unit: Annotated[str | None, typer.Option(help="Unit of the file's numbers, where the file states none.")] = None,
) -> None:
    """Look at records before any model: health, noise, lines, resonances, and how they seem to be driven."""
    from mechid.cli.output import print_result
    from mechid.errors import RecordError
    from mechid.locks import hold_folder
    from mechid.looks.run import look as looked

    with hold_folder(out):
        found = looked(*records, sample_rate_hz=sample_rate_hz, columns=column or (), quantity=quantity, unit=unit)
        print_result(found, out)
    if found.left_out:
        raise RecordError(f"{len(found.left_out)} of {len(records)} could not be read: {found.left_out[0].message}")
