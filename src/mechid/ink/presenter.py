"""The presenter of one kind of result: its numbers, its document, its figures and further files.

Each capability's `document.py` has one `PRESENTER`; `mechid.shown` finds it by the kind of a result.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console

from mechid.holding import hold_folder
from mechid.ink.document import Document
from mechid.ink.in_markdown import document_markdown
from mechid.ink.on_terminal import print_document
from mechid.ink.sheet import FOLDER_NAME
from mechid.writing import write_together

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HTML_WIDTH, TEXT_WIDTH = 110, 120
"""Columns of a result in a notebook, and as text."""
PRE = (
    "<pre style=\"font-family: 'DejaVu Sans Mono', Menlo, Consolas, monospace; line-height: normal; "
    'white-space: pre; overflow-x: auto">{code}</pre>'
)
Text = str | Iterable[str]
"""Of a file: whole, or in pieces."""
Drawn = Iterator[tuple[str, "Figure"]]


def _no_figures(_result: Any, _numbers: Mapping[str, Any]) -> Drawn:
    return iter(())


def _no_texts(_result: Any, _numbers: Mapping[str, Any]) -> dict[str, Text]:
    return {}


def _no_files(_result: Any, _numbers: Mapping[str, Any], _folder: Path) -> list[Path]:
    return []


@dataclass(frozen=True, kw_only=True)
class Presenter:
    """How one kind of result is shown.

    Attributes
    ----------
    name : str
        Of its page and its Markdown, without a suffix; empty: it has neither.
    numbers : callable
        From the result to the dict of every number that is shown.
    document : callable
        From that dict to the document.
    line : callable
        From the result to a line of words.
    texts : callable
        From the result and its numbers to the further text files, their contents by name.
    files : callable
        From the same and the folder to the files that it writes there itself: those that are no text, and those that
        depend on where they lie. It comes first, so that it can refuse a folder.
    figures : callable
        From the same to its figures by name, drawn one after the other.
    figure_folder : str
        Where they lie, from the result's folder; empty: in that itself.
    style : str
        Rules of its page that no other has.
    """

    name: str
    numbers: Callable[[Any], dict[str, Any]]
    document: Callable[[Mapping[str, Any]], Document]
    line: Callable[[Any], str]
    texts: Callable[[Any, Mapping[str, Any]], Mapping[str, Text]] = _no_texts
    files: Callable[[Any, Mapping[str, Any], Path], list[Path]] = _no_files
    figures: Callable[[Any, Mapping[str, Any]], Drawn] = _no_figures
    figure_folder: str = FOLDER_NAME
    style: str = ""

    def write(self, result: Any, numbers: Mapping[str, Any], folder: Path) -> list[Path]:
        """Write page, Markdown, figures and further files into a folder, held meanwhile, and return them.

        Returns
        -------
        list of Path
            The files, and the folder of the figures where they have one of their own.

        Raises
        ------
        UsageError
            The folder cannot be written to.
        """
        from mechid.ink.on_page import document_page

        with hold_folder(folder):
            own = self.files(result, numbers, folder)
            figures = self._write_figures(result, numbers, folder / self.figure_folder)
            texts, document = dict(self.texts(result, numbers)), self.document(numbers)
            if self.name:
                texts[f"{self.name}.md"] = document_markdown(document)
                texts[f"{self.name}.html"] = document_page(document, figures, self.style)
            own += write_together(folder, texts)
            if figures and self.figure_folder:
                return [*own, folder / self.figure_folder]
            return [*own, *(folder / f"{name}.svg" for name in figures)]

    def _write_figures(self, result: Any, numbers: Mapping[str, Any], folder: Path) -> Any:
        if self.figures is _no_figures:
            return {}
        from mechid.ink.figures import write_figures  # Matplotlib takes half a second to load

        return write_figures(self.figures(result, numbers), folder)

    def print(self, numbers: Mapping[str, Any], console: Console, files: Sequence[Path] = ()) -> None:
        """Print what `numbers` made, and where its files are."""
        print_document(self.document(numbers), console, files)

    def text(self, result: Any) -> str:
        """Return the text that its command prints of a result."""
        console = Console(file=io.StringIO(), width=TEXT_WIDTH, markup=False, highlight=False, emoji=False)
        self.print(self.numbers(result), console)
        assert isinstance(console.file, io.StringIO)
        return console.file.getvalue().rstrip("\n")

    def html(self, result: Any) -> str:
        """Return the same as HTML for a notebook."""
        console = Console(
            file=io.StringIO(),
            record=True,
            width=HTML_WIDTH,
            markup=False,
            highlight=False,
            emoji=False,
            force_terminal=True,
            force_jupyter=False,
        )
        self.print(self.numbers(result), console)
        return console.export_html(inline_styles=True, code_format=PRE)
