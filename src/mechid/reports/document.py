"""Presenter of a fit; `sections` makes its document.

The two modules are separate because the run that writes a report imports the sections, and the presenter the run.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mechid.identification.result.fit import Fit
from mechid.ink.presenter import Presenter
from mechid.reports.numbers import report_data
from mechid.reports.sections import report_document


class FitPresenter(Presenter):
    """Presenter of a fit, whose files are those of `mechid.report`."""

    def write(self, result: Fit, numbers: Mapping[str, Any], folder: Path, *, docx: bool = False) -> list[Path]:
        """Write the results and the report into a folder, with `docx` also the test report."""
        from mechid.reports.run import report  # loads the search, which a fit that is shown does not need

        del numbers
        return report(result, folder, docx=docx)


PRESENTER = FitPresenter(
    name="",
    numbers=report_data,
    document=report_document,
    line=lambda fit: f"grade {fit.grade}, {len(fit.correlation_names)} free parameters, {len(fit.records)} records",
)
