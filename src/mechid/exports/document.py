"""Document of an export: mechanism, files, verification and remarks."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mechid.ink.document import IN_DOCUMENTS, ON_TERMINAL, Document, Facts, Lines, Picture, Section, Words
from mechid.ink.presenter import Presenter

# The folder may contain a page of the user under a common name.
NAME = "mechid_export"
"""Base name of page and Markdown."""
PAGES = (f"{NAME}.md", f"{NAME}.html")


def export_numbers(done: Any) -> dict[str, Any]:
    """Return the content of mechid_export.json, the folder of the files and the words of the figures by name."""
    return {
        **done.to_dict(),
        "folder": str(done.folder),
        "figures": {name: words for name, words, _ in done.written.figures},
    }


def export_document(data: Mapping[str, Any]) -> Document:
    """Make the document from the result of `export_numbers`."""
    made, fit = data["provenance"], data["provenance"]["fit"]
    digests = [f"{name}: {digest}" for name, digest in fit.get("inputs_sha256", {}).items()]
    facts = [("target", data["target"]), ("grade of the fit", made["grade"]), ("mechid", made["mechid"])]
    facts += [("seed of the fit", str(fit["seed"]))] if "seed" in fit else []
    checked, known = _check_words(data["checked"]), (*data["words"], str(made["trust"]))
    return Document(
        title="An export",
        command="mechid export",
        under=f"Target {data['target']}",
        parts=(
            Words(str(data["mechanism"])),
            *(Words(str(Path(data["folder"]) / name), where=ON_TERMINAL) for name in data["files"]),
            Section("Files", (Lines(data["files"]),), "files", "Files", where=IN_DOCUMENTS),
            Words(checked, where=ON_TERMINAL),
            Section("Check", (Words(checked),), "check", "Check", where=IN_DOCUMENTS),
            *(Picture(name, words, folder="") for name, words in data["figures"].items()),
            *(Words(line, where=ON_TERMINAL) for line in known),
            Section("What to know", (Lines(known),), "words", "What to know", where=IN_DOCUMENTS),
            Section("Provenance", (Facts(facts), Lines(digests)), "provenance", "Provenance", where=IN_DOCUMENTS),
        ),
    )


def _check_words(checked: Mapping[str, Any] | None) -> str:
    if checked is None:
        return "Not checked."
    errors = f"largest error {checked['largest_error']:.3g}, RMS {checked['rms_error']:.3g}"
    return f"Checked against {checked['against']}: {errors}."


PRESENTER = Presenter(
    name=NAME,
    numbers=export_numbers,
    document=export_document,
    line=lambda done: f"{done.target} in {done.folder}",
    files=lambda done, _numbers, _folder: [done.folder / name for name in done.written.files],
    figures=lambda done, _numbers: ((name, draw()) for name, _, draw in done.written.figures),
    figure_folder="",
)
