"""``mechid simulate``: simulation of records with the mechanism as written."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def simulate(
    campaign: Annotated[Path, typer.Argument(metavar="CAMPAIGN", help="campaign.toml, or its folder.")],
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="Folder for <record>.csv, page and numbers; made where missing.")
    ],
    sample_rate_hz: Annotated[
        float | None, typer.Option(help="For records without a file, else 10000 or as others have it.")
    ] = None,
    duration_s: Annotated[
        float | None, typer.Option(help="For records without a file, else to the end of the rate profile, or 1.")
    ] = None,
) -> None:
    """Simulate each record at the mechanism's values, without noise."""
    from mechid.campaign import load_campaign
    from mechid.campaign.prediction import time_base_warnings
    from mechid.campaign.trajectory_file import refuse_measured
    from mechid.cli.kernel_notice import prepare_kernel
    from mechid.cli.output import print_result
    from mechid.ink.console import console_on, print_lines
    from mechid.locks import hold_folder
    from mechid.simulations.run import simulate_campaign

    loaded = load_campaign(campaign, need_files=False)
    with hold_folder(out):
        measured = [record.file for record in loaded.records if record.file is not None]
        refuse_measured(measured, [record.name for record in loaded.records], out)
        warnings = (*loaded.warnings, *time_base_warnings(loaded, sample_rate_hz, duration_s))
        print_lines(console_on(err=True), "warning", warnings)
        prepare_kernel(loaded.mechanism.plant)
        print_result(simulate_campaign(loaded, sample_rate_hz=sample_rate_hz, duration_s=duration_s), out)
