"""Files of a report next to an estimate: page, figures, tables, and all numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from mechid.analysis.validation import RecordValidation
from mechid.campaign import Campaign
from mechid.identification.result.estimate_file import FILE, json_text
from mechid.identification.result.fit import ESTIMATE_NAME, Fit
from mechid.ink.docx_file import picture_files, text_digests, write_docx
from mechid.ink.in_markdown import document_markdown
from mechid.ink.on_page import interactive_page
from mechid.ink.pens import Pens
from mechid.ink.sheet import FOLDER_NAME
from mechid.kernel.equation_text import equations_mathml
from mechid.reports.contents import report_contents
from mechid.reports.figure_cache import page_script
from mechid.reports.illustration import Illustration
from mechid.reports.results import MECHANISM_NAME, REPORT_NAME
from mechid.reports.sections import report_document
from mechid.reports.verification import fit_report
from mechid.writing import write_together

PAGE_NAME = "report.html"
TABLES_NAME = "report.md"
DOCX_NAME = "report.docx"


def write_report(
    data: Mapping[str, Any],
    campaign: Campaign,
    fit: Fit,
    validation: Mapping[str, RecordValidation],
    folder: Path | str,
    illustration: Illustration | None = None,
    *,
    docx: bool = False,
) -> list[Path]:
    """Write report.html, report.json, report.md and the folder figures; with `docx` also report.docx.

    Each file is written under a temporary name; then earlier ones are replaced.

    Parameters
    ----------
    data : mapping
        As `report_data` makes it, with the validation.
    campaign : Campaign
        The identified campaign with its records read.
    fit : Fit
    validation : mapping
        Of the records, as `validate` makes it.
    folder : Path
        Made with its parents where it is missing.
    illustration : Illustration or None
        Figures already started; None starts them here.
    docx : bool
        Whether the test report is written too, as a Word document.

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
    if illustration is None:
        with Pens() as pens, Illustration(campaign, fit, folder, pens) as own:
            for record in validation.values():
                own.begin(record)
            return write_report(data, campaign, fit, validation, folder, own, docx=docx)
    contents = report_contents(data, campaign, fit)
    # All figures are drawn before a text is replaced, so that no page names a missing figure.
    curves, pictures = illustration.finish(contents)
    document = report_document(contents, curves, equations_mathml(fit.mechanism.plant))
    texts: dict[str, str | Iterable[str]] = {
        PAGE_NAME: interactive_page(document, pictures, page_script(curves, contents["resonances"])),
        REPORT_NAME: json_text(contents),
        TABLES_NAME: document_markdown(document),
    }
    files = write_together(folder, texts)
    if docx:
        names = (ESTIMATE_NAME, str(contents["provenance"].get(FILE, MECHANISM_NAME)))
        results = [path for name in names if (path := folder / name).is_file()]
        report = fit_report(contents, campaign, document, text_digests([*results, *files]))
        files.append(write_docx(report, picture_files(folder / FOLDER_NAME, pictures), folder / DOCX_NAME))
    return [*files, folder / FOLDER_NAME]
