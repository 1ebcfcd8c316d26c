"""``mechid quiet``: microstep table, rates and stepping with which the mechanism disturbs least."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def quiet(
    fit: Annotated[Path, typer.Argument(metavar="FIT", help="Result folder of mechid identify, or its campaign.toml.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results; made where missing.")],
    design: Annotated[
        Path | None, typer.Option(metavar="FILE", help="quiet.toml: rates, orders, range, bits, limits.")
    ] = None,
    fleet: Annotated[
        list[Path] | None,
        typer.Option(metavar="DIR", help="Fit of another unit, on which the table is tried; may be repeated."),
    ] = None,
) -> None:
    """Find the microstep table, rates and stepping with which the mechanism disturbs least."""
    from mechid.cli.output import print_result, say
    from mechid.locks import hold_folder
    from mechid.quiet_drives.design_file import read_quiet_file
    from mechid.quiet_drives.run import quiet as made_quiet

    # A wrong file is refused before the records of the fit are read.
    wanted = None if design is None else read_quiet_file(design)
    with hold_folder(out):
        found = made_quiet(fit, wanted, fleet=fleet or (), say=say)
        print_result(found, out)
