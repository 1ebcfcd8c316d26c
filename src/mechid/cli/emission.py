"""``mechid emission``: exported forces and torques against their specification."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mechid.cli.docx_option import Docx


def emission(
    campaign: Annotated[Path, typer.Argument(metavar="CAMPAIGN", help="campaign.toml, or the folder that holds it.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for the results; made where missing.")],
    requirements: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="File with the [[requirement]] tables, in place of those of the campaign."),
    ] = None,
    fit: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Results of mechid identify: predict the torque at rates not tested, too."),
    ] = None,
    flight: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="File with a [flight] table: predict with its values, off the test stand."),
    ] = None,
    docx: Docx = False,
    strict: Annotated[bool, typer.Option("--strict", help="Exit with 5 where a verdict is not a pass.")] = False,
) -> None:
    """Judge the emission at the interface against its specification, from records alone or with a fit."""
    from mechid.cli.output import print_result
    from mechid.emissions.run import emission as judged
    from mechid.errors import FitError
    from mechid.ink.docx_file import refuse_without_docx
    from mechid.locks import hold_folder

    if docx:
        refuse_without_docx()
    with hold_folder(out):
        found = judged(campaign, requirements=requirements, fit=fit, flight=flight)
        print_result(found, out, docx=docx)
    if strict and not found.passes:
        open_ones = ", ".join(one.requirement.name for one in found.assessments if one.verdict != "pass")
        raise FitError(f"not shown to be met: {open_ones}; see {out / 'emission.md'}")
