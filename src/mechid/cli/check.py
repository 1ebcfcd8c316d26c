"""``mechid check``: content of a campaign or a data file, as interpreted by mechid."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def check(
    campaign: Annotated[
        Path, typer.Argument(metavar="CAMPAIGN|FILE", help="campaign.toml, its folder, or a data file.")
    ],
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder for page, numbers and a picture of each record; made where missing."),
    ] = None,
) -> None:
    """Say what was understood of a campaign, or list a data file."""
    from mechid.campaign import load_campaign
    from mechid.checks.data_file import file_document, file_numbers
    from mechid.checks.run import check as checked
    from mechid.cli.kernel_notice import prepare_kernels
    from mechid.cli.output import print_result
    from mechid.errors import UsageError
    from mechid.ink.console import console_on
    from mechid.ink.on_terminal import print_document
    from mechid.reading.whole import is_folder

    if campaign.suffix.lower() not in ("", ".toml") and not is_folder(campaign):
        if out is not None:
            raise UsageError(f"--out: {campaign} is a data file; pictures are of a campaign's records")
        print_document(file_document(file_numbers(campaign)), console_on())
        return
    loaded = load_campaign(campaign, need_files=False)
    prepare_kernels(loaded)
    print_result(checked(loaded), out)
