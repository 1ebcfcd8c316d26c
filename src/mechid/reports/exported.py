"""Files of an export, on a terminal."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.console import Console


def print_exported(data: Mapping[str, Any], console: Console) -> None:
    """Print which mechanism it is, the files in their ``folder``, what they were compared with, and what to know."""
    console.print(str(data["mechanism"]), soft_wrap=True, highlight=False)
    for name in data["files"]:
        console.print(str(Path(data["folder"]) / name), soft_wrap=True)
    checked = data["checked"]
    if checked is None:
        console.print("Not checked.")
    else:
        errors = f"largest error {checked['largest_error']:.3g}, RMS {checked['rms_error']:.3g}"
        console.print(f"Checked against {checked['against']}: {errors}.")
    for line in (*data["words"], str(data["provenance"]["trust"])):
        console.print(line, soft_wrap=True, highlight=False)
