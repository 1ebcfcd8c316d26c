"""Curves and figures of the records of a report, started as soon as a record is validated.

Figures take longer than all other parts of a report. They are drawn record by record while the next record is validated
and while the parts without figures are computed.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Future, wait
from functools import cached_property
from pathlib import Path
from shutil import rmtree
from types import TracebackType
from typing import Any, Self

from mechid.analysis.prediction import Prediction
from mechid.analysis.validation import RecordValidation
from mechid.campaign import Campaign
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.result.fit import Fit
from mechid.ink.pens import Pens
from mechid.ink.sheet import FOLDER_NAME
from mechid.reports.curves import Curves, record_curves
from mechid.reports.details import resonance_data
from mechid.reports.figures import channel_sheets, matrix_sheets
from mechid.simulation.resonances import resonances
from mechid.writing import creating_folder


class Illustration:
    """Curves and running drawings of a report; an error that leaves its context cancels the drawings.

    Parameters
    ----------
    campaign : Campaign
    fit : Fit
        The validated fit.
    folder : Path
        Folder of the report; the figures have a folder inside it.
    pens : Pens
    """

    def __init__(self, campaign: Campaign, fit: Fit, folder: Path, pens: Pens) -> None:
        self.folder = folder / FOLDER_NAME
        self._campaign, self._fit, self._pens = campaign, fit, pens
        self._curves: list[Curves] = []
        self._pictures: dict[str, Future[None]] = {}
        self._failed: Exception | None = None
        self._is_new = not self.folder.exists()

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Cancel the figures after an error."""
        if kind is not None:
            self.give_up()

    def give_up(self) -> None:
        """Cancel the figures, and remove their folder if it is new."""
        for picture in self._pictures.values():
            picture.cancel()
        wait(self._pictures.values())  # what is being drawn would make the folder again
        if self._is_new:
            rmtree(self.folder, ignore_errors=True)

    @cached_property
    def _resonances(self) -> list[dict[str, Any]]:
        return resonance_data(resonances(self._fit.mechanism))

    def begin(self, record: RecordValidation, predictions: Mapping[str, Prediction] | None = None) -> None:
        """Compute the curves of a record, and start drawing its figures.

        Errors are stored and raised by `finished`, since the caller first has results to write.
        """
        if self._failed:
            return
        try:
            # The matrices are small: shared among cores, a factorisation takes longer.
            with creating_folder(self.folder), one_core_algebra():
                curves = record_curves(self._campaign, self._fit, record, predictions)
            for one in curves:
                self._pictures |= self._pens.draw(channel_sheets(one, self._resonances), self.folder)
            self._curves += curves
        except Exception as error:
            self._failed = error

    def finish(self, contents: Mapping[str, Any]) -> tuple[list[Curves], dict[str, Path]]:
        """Draw the matrices, wait for all figures, and return the curves in order and the SVG files by name.

        Raises
        ------
        UsageError
            The folder cannot be written to.
        """
        if self._failed:
            raise self._failed
        with creating_folder(self.folder):
            self._pictures |= self._pens.draw(matrix_sheets(contents), self.folder)
            for picture in self._pictures.values():
                picture.result()
        return self._curves, {name: self.folder / f"{name}.svg" for name in self._pictures}
