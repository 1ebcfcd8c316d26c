"""``mechid new``: templates of mechanism and campaign files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def new(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder to write into; made where missing.")],
    files: Annotated[
        list[Path] | None, typer.Argument(metavar="[FILES]...", help="Measured files, a record for each.")
    ] = None,
    assembly: Annotated[
        str,
        typer.Option(metavar="NAME", help="What it is made of, as brushed_dc_drive; see docs/blocks/assemblies.md."),
    ] = "stepper_gear_mass",
) -> None:
    """Write a commented mechanism.toml and campaign.toml to fill in."""
    from mechid.campaign import new_campaign

    for path in new_campaign(folder, files or (), assembly):
        typer.echo(f"written: {path}")
    # Files may be recorded later, so a missing one is only a warning.
    for file in files or ():
        if not file.is_file():
            problem = "is a folder, no file" if file.is_dir() else "there is no such file yet"
            typer.echo(f"warning: {file}: {problem}", err=True)
    typer.echo(f"next: fill them in; mechid check {folder} says what is left")
