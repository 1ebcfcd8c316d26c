"""The report's files of a budget: page, Markdown, figures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mechid.ink.figures import write_figures
from mechid.ink.sheet import FOLDER_NAME
from mechid.reports.budget.contents import budget_contents
from mechid.reports.budget.figures import budget_figures
from mechid.reports.budget.markdown import budget_markdown
from mechid.reports.budget.page import budget_page
from mechid.writing import writable, write_together

PAGE_NAME, TABLES_NAME = "budget.html", "budget.md"


def write_budget_report(data: Mapping[str, Any], folder: Path | str) -> list[Path]:
    """Write budget.html, budget.md and the figures of what `budget_data` made; earlier ones are replaced.

    Returns
    -------
    list of Path
        The files, and the folder of the figures.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    folder, contents = Path(folder), budget_contents(data)
    with writable(folder):
        pictures = write_figures(budget_figures(contents).items(), folder / FOLDER_NAME)
    texts = {PAGE_NAME: budget_page(contents, pictures), TABLES_NAME: budget_markdown(contents)}
    return [*write_together(folder, texts), folder / FOLDER_NAME]
