"""``mechid report``: new report of a finished identification."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mechid.cli.docx_option import Docx


def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Result folder of mechid identify or demo.")],
    campaign: Annotated[
        Path | None, typer.Option(metavar="CAMPAIGN", help="Its campaign.toml; the journal's without it.")
    ] = None,
    docx: Docx = False,
) -> None:
    """Make the report of an identification anew."""
    from mechid.cli.kernel_notice import prepare_kernels
    from mechid.fits.load import load_fit
    from mechid.ink.console import console_on, print_lines
    from mechid.ink.docx_file import refuse_without_docx
    from mechid.locks import hold_folder
    from mechid.reports.results import read_truth
    from mechid.reports.run import report as reported

    if docx:
        refuse_without_docx()
    read_truth(folder)
    with hold_folder(folder):
        fit = load_fit(folder, campaign)
        if fit.campaign:
            prepare_kernels(fit.campaign)
        print_lines(console_on(), "written", map(str, reported(fit, folder, docx=docx)))
