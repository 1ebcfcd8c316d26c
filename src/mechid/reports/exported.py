"""What an export has written, on a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from mechid.exports.export import Exported


def print_exported(done: Exported, console: Console) -> None:
    """Print the files, what they were compared with, and what their user has to know."""
    for name in done.written.files:
        console.print(str(done.folder / name), soft_wrap=True)
    checked = done.written.checked
    if checked is None:
        console.print("Not checked.")
    else:
        errors = f"largest error {checked.largest_error:.3g}, RMS {checked.rms_error:.3g}"
        console.print(f"Checked against {checked.against}: {errors}.")
    for line in (*done.written.words, str(done.provenance["trust"])):
        console.print(line, soft_wrap=True, highlight=False)
