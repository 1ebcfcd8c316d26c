"""``mechid check``: what was understood of a campaign, or of a data file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def check(
    campaign: Annotated[
        Path, typer.Argument(metavar="CAMPAIGN|FILE", help="campaign.toml, its folder, or a data file.")
    ],
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write a picture of each record with its command into DIR.")
    ] = None,
) -> None:
    """Say what was understood of a campaign, or list a data file."""
    from mechid.campaign import load_campaign
    from mechid.cli.kernel_notice import prepare_kernels
    from mechid.errors import UsageError
    from mechid.identification.identifiability.visibility import start_warnings
    from mechid.identification.stages.first_seen import declaration_warnings
    from mechid.reading.whole import is_folder
    from mechid.reports import campaign_data, file_data, print_campaign, print_file
    from mechid.reports.terminal import console_on, print_lines

    if campaign.suffix.lower() not in ("", ".toml") and not is_folder(campaign):
        if out is not None:
            raise UsageError(f"--out: {campaign} is a data file; pictures are of a campaign's records")
        print_file(file_data(campaign), console_on())
        return
    loaded = load_campaign(campaign, need_files=False)
    prepare_kernels(loaded)
    print_campaign(campaign_data(loaded, (*declaration_warnings(loaded), *start_warnings(loaded))), console_on())
    if out is not None:
        from mechid.holding import held
        from mechid.reports.record_figures import write_record_figures

        with held(out):
            print_lines(console_on(), "written", map(str, write_record_figures(loaded, out)))
