"""The files of a diagnosis: every number, page, Markdown, figures, the mechanism proposed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mechid.campaign.mechanism_text import mechanism_text
from mechid.identification.diagnosis.diagnosis import Diagnosis
from mechid.identification.result.diagnosis_file import FILE_NAME as DATA_NAME
from mechid.identification.result.diagnosis_file import PROPOSED_NAME
from mechid.identification.result.estimate_file import json_text
from mechid.ink.figures import write_figures
from mechid.ink.sheet import FOLDER_NAME
from mechid.reports.diagnosis.figures import diagnosis_figures
from mechid.reports.diagnosis.markdown import diagnosis_markdown
from mechid.reports.diagnosis.page import diagnosis_page
from mechid.writing import writable, write_together

PAGE_NAME, MARKDOWN_NAME = "diagnose.html", "diagnose.md"
PROPOSED = (
    "Proposed by mechid diagnose: the mechanism file with the effects that the records ask for, at the values found\n"
    "together with them. Nothing of it is sure before it was identified anew and makes sense for this mechanism."
)


def write_diagnosis(found: Diagnosis, data: Mapping[str, Any], folder: Path | str) -> list[Path]:
    """Write diagnose.json, its page, Markdown and figures, and the proposed mechanism where there is one.

    Returns
    -------
    list of Path
        The files, and the folder of the figures where there are any.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    folder = Path(folder)
    figures: dict[str, str] = {}
    if data["drawn"]["spectra"]:
        with writable(folder):
            figures = write_figures(diagnosis_figures(found.pictures), folder / FOLDER_NAME)
    page = diagnosis_page(data, figures)
    texts = {DATA_NAME: json_text(_plain(data)), MARKDOWN_NAME: diagnosis_markdown(data), PAGE_NAME: page}
    if found.mechanism is not None:
        texts[PROPOSED_NAME] = mechanism_text(found.mechanism, PROPOSED)
    return [*write_together(folder, texts), *([folder / FOLDER_NAME] if figures else [])]


def _plain(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers alone."""
    missing = [{k: v for k, v in one.items() if k not in ("rows", "text", "places")} for one in data["missing"]]
    return {**{k: v for k, v in data.items() if k not in ("path", "drawn")}, "missing": missing}
