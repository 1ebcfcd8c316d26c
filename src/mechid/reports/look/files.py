"""The files of a look: page, every number, CSV, figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mechid.analysis.look import RecordLook
from mechid.identification.result.estimate_file import json_text
from mechid.ink.figures import write_figures
from mechid.ink.sheet import FOLDER_NAME
from mechid.reports.look.csv_files import look_tables
from mechid.reports.look.figures import look_figures
from mechid.reports.look.page import look_page
from mechid.writing import writable, write_together

PAGE_NAME, JSON_NAME, CSV_FOLDER = "look.html", "look.json", "csv"


def write_look(data: Mapping[str, Any], looks: Sequence[RecordLook], folder: Path | str) -> list[Path]:
    """Write look.html, look.json, the folder csv and the folder figures; earlier ones are replaced.

    Parameters
    ----------
    data : mapping
        As `look_data` makes it of the same looks.
    looks : sequence of RecordLook
    folder : Path
        Made with its parents where it is missing.

    Returns
    -------
    list of Path
        The files, and both folders.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    folder = Path(folder)
    with writable(folder):
        pictures = write_figures(look_figures(looks), folder / FOLDER_NAME)
    write_together(folder / CSV_FOLDER, look_tables(data, looks))
    texts = {PAGE_NAME: look_page(data, pictures), JSON_NAME: json_text(data)}
    return [*write_together(folder, texts), folder / CSV_FOLDER, folder / FOLDER_NAME]
