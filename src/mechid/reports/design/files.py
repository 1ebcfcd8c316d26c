"""The files of a design: every number, Markdown, the campaign proposed, torque over rate, figures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mechid.campaign.mechanism_text import mechanism_text
from mechid.campaign.templates import MECHANISM_NAME
from mechid.designs.design import Design
from mechid.designs.numbers import design_data, rate_rows
from mechid.designs.proposal import has_file, proposed_campaign, proposed_options
from mechid.errors import UsageError
from mechid.identification.result.estimate_file import json_text
from mechid.ink.figures import write_figures
from mechid.ink.sheet import FOLDER_NAME
from mechid.reports.design.figures import design_figures
from mechid.reports.design.markdown import design_markdown
from mechid.reports.design.verdict import JSON_NAME
from mechid.writing import writable, write_together

MARKDOWN_NAME, CAMPAIGN_NAME, OPTIONS_NAME = "design.md", "campaign.toml", "design.toml"
RATES_NAME = "torque_over_rate.csv"


def write_design(design: Design, folder: Path | str, data: Mapping[str, Any] | None = None) -> list[Path]:
    """Write design.json, design.md, the proposed campaign, torque over rate and figures; return the files.

    `data` is what `design_data` made, where it is at hand.

    Raises
    ------
    UsageError
        The folder cannot be written to, or holds the campaign itself.
    """
    folder = Path(folder)
    refuse_own_folder(design.campaign.path, folder)
    data = design_data(design) if data is None else data
    texts = {
        JSON_NAME: json_text(data),
        MARKDOWN_NAME: design_markdown(data),
        CAMPAIGN_NAME: proposed_campaign(design, data, folder),
        OPTIONS_NAME: proposed_options(design),
        **({} if has_file(design) else {MECHANISM_NAME: mechanism_text(design.campaign.mechanism)}),
        RATES_NAME: "".join(rate_rows(data)),
    }
    files = write_together(folder, texts)
    with writable(folder):
        write_figures(design_figures(data).items(), folder / FOLDER_NAME)
    return [*files, folder / FOLDER_NAME]


def refuse_own_folder(campaign: Path, folder: Path) -> None:
    """Raise UsageError where the proposal would replace the campaign file that it is made from."""
    if folder.resolve() == campaign.parent.resolve():
        raise UsageError(f"{folder}: holds the campaign itself, which must not be replaced; give another folder")
