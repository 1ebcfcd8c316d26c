"""Base class of results that display and write themselves.

A result is defined in the layer that computes it. Its document and its files belong to a capability, which may be a
higher layer: the module of that capability is named here and imported on first use, so that no layer imports a higher
one.
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
    "QuietDrive": "mechid.quiet_drives.document",
    "Simulated": "mechid.simulations.document",
    "Survey": "mechid.looks.document",
    "Trajectory": "mechid.simulations.document",
    "Understanding": "mechid.checks.document",
    "Validations": "mechid.validations.document",
}
"""Document module of each result class; the module's `PRESENTER` displays and writes the result."""


def presenter_of(result: object) -> Any:
    """Return the `ink.presenter.Presenter` of a result's class."""
    return import_module(DOCUMENTS[type(result).__name__]).PRESENTER


class DisplayedResult:
    """A result of one of mechid's functions.

    In a notebook it displays the output of the command of the same name.
    """

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """Return all displayed numbers as JSON-compatible values, in SI units unless the key states another."""
        found: dict[str, Any] = presenter_of(self).numbers(self)
        return found

    def write(self, out: Path | str, *, docx: bool = False) -> list[Path]:
        """Write the files of the command of the same name into a folder, created if missing, and return their paths.

        Parameters
        ----------
        out : Path
        docx : bool
            Whether the test report is written too, as a Word document (extra ``office``).

        Raises
        ------
        UsageError
            The folder cannot be written to; or a Word document is wanted, and python-docx is not installed, or this
            kind of result has no test report.
        """
        own = presenter_of(self)
        files: list[Path] = own.write(self, own.numbers(self), Path(out), docx=docx)
        return files

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {presenter_of(self).line(self)}>"

    def __str__(self) -> str:
        """Return the text that the command prints."""
        text: str = presenter_of(self).text(self)
        return text

    def _repr_html_(self) -> str:
        html: str = presenter_of(self).html(self)
        return html
