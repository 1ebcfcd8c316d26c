"""The report's files beside an estimate: page, figures, tables, every number."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from mechid.analysis.validation import RecordValidation
from mechid.campaign import Campaign
from mechid.identification.result.estimate_file import json_text
from mechid.identification.result.fit import Fit
from mechid.kernel.equation_text import equations_mathml
from mechid.reports.contents import report_contents
from mechid.reports.curves import record_curves
from mechid.reports.details import resonance_data
from mechid.reports.markdown import report_markdown
from mechid.reports.page import report_page
from mechid.reports.paper import channel_sheets, matrix_sheets
from mechid.reports.pens import Pens
from mechid.reports.results import REPORT_NAME
from mechid.reports.sheet import FOLDER_NAME
from mechid.simulation.resonances import resonances
from mechid.writing import writable, write_together

PAGE_NAME = "report.html"
TABLES_NAME = "report.md"


def write_report(
    data: Mapping[str, Any],
    campaign: Campaign,
    fit: Fit,
    validation: Mapping[str, RecordValidation],
    folder: Path | str,
    pens: Pens | None = None,
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
    pens : Pens or None
        What draws the figures, where it is there already.

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
    with writable(folder):
        (folder / FOLDER_NAME).mkdir(parents=True, exist_ok=True)
    with writable(folder), nullcontext(pens) if pens else Pens() as drawing:
        curves = [one for record in validation.values() for one in record_curves(campaign, fit, record)]
        swinging = resonance_data(resonances(fit.mechanism))
        sheets = (sheet for one in curves for sheet in channel_sheets(one, swinging))
        pictures = drawing.draw(sheets, folder / FOLDER_NAME)
        contents = report_contents(data, campaign, fit)
        pictures |= drawing.draw(matrix_sheets(contents), folder / FOLDER_NAME)
        equations = equations_mathml(fit.mechanism.plant)
        texts = {REPORT_NAME: json_text(contents), TABLES_NAME: report_markdown(contents)}
        drawn = {name: picture.result() for name, picture in pictures.items()}
    page = {PAGE_NAME: report_page(contents, curves, drawn, equations)}
    return [*write_together(folder, page | texts), folder / FOLDER_NAME]
