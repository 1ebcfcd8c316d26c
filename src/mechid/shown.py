"""Results that show and write themselves.

A result stands in the layer that makes it; its document and its files are made by its capability, which may stand above
it. That module is named here and imported when a result is asked, so that no import goes up.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

SIMULATED = "the records were simulated, nothing of this was measured."
SYNTHETIC = f"SYNTHETIC: {SIMULATED}"

DOCUMENTS: Mapping[str, str] = {
    "Bootstrap": "mechid.bootstraps.document",
    "Budget": "mechid.budgets.document",
    "Comparison": "mechid.comparisons.document",
    "Design": "mechid.designs.document",
    "Diagnosis": "mechid.diagnoses.document",
    "Emission": "mechid.emissions.document",
    "Exported": "mechid.exports.document",
    "Fit": "mechid.reports.document",
    "Fleet": "mechid.fleets.document",
    "Index": "mechid.indexes.document",
    "Profiles": "mechid.profiles.document",
    "Simulated": "mechid.simulations.document",
    "Survey": "mechid.looks.document",
    "Trajectory": "mechid.simulations.document",
    "Understanding": "mechid.checks.document",
    "Validations": "mechid.validations.document",
}
"""Module of the document of each kind of result; its `PRESENTER` shows and writes the result."""


def presenter_of(result: object) -> Any:
    """Return the `ink.presenter.Presenter` of a result's kind."""
    return import_module(DOCUMENTS[type(result).__name__]).PRESENTER


class Shown:
    """A result of one of mechid's functions.

    In a notebook it shows what the command of the same name prints.
    """

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """Return every number that is shown, in SI units or as its key says, as JSON can hold it."""
        found: dict[str, Any] = presenter_of(self).numbers(self)
        return found

    def write(self, out: Path | str) -> list[Path]:
        """Write what the command of the same name leaves in a folder, made where it is missing; return the files.

        Raises
        ------
        UsageError
            The folder cannot be written to.
        """
        own = presenter_of(self)
        files: list[Path] = own.write(self, own.numbers(self), Path(out))
        return files

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {presenter_of(self).line(self)}>"

    def __str__(self) -> str:
        """Return what the command prints."""
        text: str = presenter_of(self).text(self)
        return text

    def _repr_html_(self) -> str:
        html: str = presenter_of(self).html(self)
        return html
