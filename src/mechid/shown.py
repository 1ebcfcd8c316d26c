"""Results that show and write themselves.

A result stands in the layer that makes it; its numbers as a dict, its files and its ink are made in layers above. A
result names the module that knows them, which is imported when a result is asked, so that no import goes up.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

SIMULATED = "the records were simulated, nothing of this was measured."
SYNTHETIC = f"SYNTHETIC: {SIMULATED}"

PRESENTERS = "mechid.interface.presenters"
"""Knows how each kind of result is shown and written. It stands above this module, which names it and does not
import it."""


class Shown:
    """A result of one of mechid's functions.

    In a notebook it shows what the command of the same name prints.
    """

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """Return every number that is shown, in SI units or as its key says, as JSON can hold it."""
        found: dict[str, Any] = import_module(PRESENTERS).data_of(self)
        return found

    def write(self, out: Path | str) -> list[Path]:
        """Write what the command of the same name leaves in a folder, made where it is missing; return the files.

        Raises
        ------
        UsageError
            The folder cannot be written to.
        """
        files: list[Path] = import_module(PRESENTERS).written(self, Path(out))
        return files

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {import_module(PRESENTERS).line_of(self)}>"

    def __str__(self) -> str:
        """Return what the command prints."""
        text: str = import_module(PRESENTERS).text_of(self)
        return text

    def _repr_html_(self) -> str:
        html: str = import_module(PRESENTERS).html_of(self)
        return html
