"""The report's files beside an estimate: page, figures, tables, every number."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mechid.analysis.validation import RecordValidation
from mechid.campaign import Campaign
from mechid.identification.result.estimate_file import json_text
from mechid.identification.result.fit import Fit
from mechid.kernel.equation_text import equations_mathml
from mechid.report.contents import report_contents
from mechid.report.curves import record_curves
from mechid.report.figures import FOLDER_NAME, paper_figures, write_figures
from mechid.report.markdown import report_markdown
from mechid.report.page import report_page
from mechid.report.results import REPORT_NAME
from mechid.writing import writable, write_together

PAGE_NAME = "report.html"
TABLES_NAME = "report.md"


def write_report(
    data: Mapping[str, Any],
    campaign: Campaign,
    fit: Fit,
    validation: Mapping[str, RecordValidation],
    folder: Path | str,
) -> list[Path]:
    """Write report.html, report.json, report.md and the folder figures.

    Each file is written beside its place first; earlier ones are replaced.

    Parameters
    ----------
    data : mapping
        As `report_data` makes it, with the validation.
    campaign : Campaign
        The one that was identified, its records read.
    fit : Fit
    validation : mapping
        Of the records, as `validate` makes it.
    folder : Path
        Made with its parents where it is missing.

    Returns
    -------
    list of Path
        The files, and the folder of the figures.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    folder = Path(folder)
    contents = report_contents(data, campaign, fit)
    curves = [one for record in validation.values() for one in record_curves(campaign, fit, record)]
    with writable(folder):
        pictures = write_figures(paper_figures(contents, curves), folder / FOLDER_NAME)
    texts = {
        PAGE_NAME: report_page(contents, curves, pictures, equations_mathml(fit.mechanism.plant)),
        REPORT_NAME: json_text(contents),
        TABLES_NAME: report_markdown(contents),
    }
    return [*write_together(folder, texts), folder / FOLDER_NAME]
