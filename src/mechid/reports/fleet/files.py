"""The report's files of a fleet: page and figures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mechid.ink.figures import write_figures
from mechid.ink.sheet import FOLDER_NAME
from mechid.reports.fleet.contents import fleet_contents
from mechid.reports.fleet.figures import fleet_figures
from mechid.reports.fleet.page import fleet_page
from mechid.writing import writable, write_together

PAGE_NAME = "fleet.html"


def write_fleet_report(data: Mapping[str, Any], folder: Path | str) -> list[Path]:
    """Write fleet.html and the figures of what `fleet_data` made; earlier ones are replaced.

    Returns
    -------
    list of Path
        The page, and the folder of the figures.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    folder, contents = Path(folder), fleet_contents(data)
    with writable(folder):
        pictures = write_figures(fleet_figures(contents), folder / FOLDER_NAME)
    return [*write_together(folder, {PAGE_NAME: fleet_page(contents, pictures)}), folder / FOLDER_NAME]
