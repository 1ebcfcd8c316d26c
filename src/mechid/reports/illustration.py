"""The curves of a report's records and their figures, begun as soon as a record is validated.

Figures take longer than all else of a report. Drawn record by record they are made while the next record is validated,
and while what has no figures is worked out.
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
    """What the figures of a report show, and the figures being drawn; where an error passes, they are given up.

    Parameters
    ----------
    campaign : Campaign
    fit : Fit
        As it is validated.
    folder : Path
        Of the report; the figures get one in it.
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
        """Give the figures up where an error passes."""
        if kind is not None:
            self.give_up()

    def give_up(self) -> None:
        """Leave no figures of a report that is not made: the folder goes, where it was not there before."""
        for picture in self._pictures.values():
            picture.cancel()
        wait(self._pictures.values())  # what is being drawn would make the folder again
        if self._is_new:
            rmtree(self.folder, ignore_errors=True)

    @cached_property
    def _resonances(self) -> list[dict[str, Any]]:
        return resonance_data(resonances(self._fit.mechanism))

    def begin(self, record: RecordValidation, predictions: Mapping[str, Prediction] | None = None) -> None:
        """Work out the curves of a record, and have its figures drawn.

        Nothing is raised here: whoever validates has results to write first. `finished` raises it.
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

    def finished(self, contents: Mapping[str, Any]) -> tuple[list[Curves], dict[str, Path]]:
        """Return the curves in the order begun, and the SVG files by name once all are drawn; matrices are drawn last.

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
