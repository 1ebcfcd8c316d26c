"""``mechid export``: a finished fit as files that others use without mechid."""

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
    from mechid.cli.printed import print_result
    from mechid.exports.export import exported, named_options
    from mechid.exports.handover import handover
    from mechid.identification.refit.rebuild import other_files
    from mechid.identification.result.fit_file import read_fit
    from mechid.interface.fits import load_campaign_of, result_folder
    from mechid.reports.console import console_on, print_lines
    from mechid.writing import refuse_unwritable

    refuse_unwritable(out)
    options = named_options(option or ())
    of = load_campaign_of(fit, campaign)
    found = read_fit(result_folder(fit))
    if changed := other_files(of, found):
        line = f"{', '.join(changed)}: changed since the fit, whose values are handed on; identify anew to have others"
        print_lines(console_on(err=True), "warning", [line])
    what = handover(found.to_dict(), found.mechanism, of, anyway=anyway, folder=found.folder)
    print_result(exported(what, to, out, options), None)
