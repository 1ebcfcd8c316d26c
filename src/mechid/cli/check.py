"""``mechid check``: what was understood of a campaign."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def check(
    campaign: Annotated[Path, typer.Argument(metavar="CAMPAIGN", help="campaign.toml, or its folder.")],
) -> None:
    """Read a campaign and say what was understood, and what is odd."""
    from mechid.campaign import load_campaign
    from mechid.cli.kernel_notice import prepare_kernels
    from mechid.identification.visibility import start_warnings
    from mechid.report import campaign_data, print_campaign
    from mechid.report.terminal import console_on

    loaded = load_campaign(campaign)
    prepare_kernels(loaded)
    print_campaign(campaign_data(loaded, start_warnings(loaded)), console_on())
