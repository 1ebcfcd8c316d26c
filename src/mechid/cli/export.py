"""``mechid export``: files of a finished fit for other tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def export(
    fit: Annotated[Path, typer.Argument(metavar="FIT", help="Result folder of mechid identify, or its campaign.toml.")],
    to: Annotated[str, typer.Option(metavar="TARGET", help="What for: see docs/export.md.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the files; made where missing.")],
    campaign: Annotated[Path | None, typer.Option(help="Where FIT does not say it.")] = None,
    anyway: Annotated[bool, typer.Option("--anyway", help="Hand on the values of a fit that failed too.")] = False,
    option: Annotated[
        list[str] | None, typer.Option(metavar="NAME=VALUE", help="Of the target, repeatable: see its page.")
    ] = None,
) -> None:
    """Hand the identified mechanism on: to control design, simulation, flight software, structure."""
    from mechid.cli.output import print_result
    from mechid.exports.export import read_options, write_export
    from mechid.exports.handover import handover
    from mechid.exports.run import read_with_campaign
    from mechid.ink.console import console_on, print_lines
    from mechid.writing import refuse_unwritable

    refuse_unwritable(out)
    options = read_options(option or ())
    finished, own, notice = read_with_campaign(fit, campaign)
    if notice:
        print_lines(console_on(err=True), "warning", [notice])
    print_result(write_export(handover(finished, own, anyway=anyway), to, out, options), None)
