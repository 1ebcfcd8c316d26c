"""Presenter of a kind of result: numbers, document, figures and further files.

The `document.py` of each capability defines one `PRESENTER`; `mechid.display` selects it by the type of a result.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console

from mechid.errors import UsageError
from mechid.ink.document import Document
from mechid.ink.docx_file import picture_files, refuse_without_docx, text_digests, write_docx
from mechid.ink.in_markdown import document_markdown
from mechid.ink.on_terminal import print_document
from mechid.ink.sheet import FOLDER_NAME
from mechid.locks import hold_folder
from mechid.writing import write_together

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HTML_WIDTH, TEXT_WIDTH = 110, 120
"""Width in columns of a result in a notebook, and as text."""
PRE = (
    "<pre style=\"font-family: 'DejaVu Sans Mono', Menlo, Consolas, monospace; line-height: normal; "
    'white-space: pre; overflow-x: auto">{code}</pre>'
)
Text = str | Iterable[str]
"""Content of a file, whole or in pieces."""
Drawn = Iterator[tuple[str, "Figure"]]


def _no_figures(_result: Any, _numbers: Mapping[str, Any]) -> Drawn:
    return iter(())


def _no_texts(_result: Any, _numbers: Mapping[str, Any]) -> dict[str, Text]:
    return {}


def _no_files(_result: Any, _numbers: Mapping[str, Any], _folder: Path) -> list[Path]:
    return []


@dataclass(frozen=True, kw_only=True)
class Presenter:
    """Presentation of one kind of result.

    Attributes
    ----------
    name : str
        File name of page and Markdown without a suffix; empty if there are none.
    numbers : callable
        Converts the result to a dict of all shown numbers.
    document : callable
        Converts that dict to the document.
    line : callable
        Summarises the result in one line.
    texts : callable
        Returns further text files by name, from the result and its numbers.
    files : callable
        Writes further files to the folder and returns them: binary files, and those that depend on their location. It
        is called first, so that it can refuse a folder.
    figures : callable
        Yields figures by name.
    figure_folder : str
        Folder of the figures, relative to the folder of the result; empty for the same folder.
    style : str
        Additional style rules of its page.
    report : callable or None
        Makes the document of the test report from the numbers, the document and the digests of the files by name; None
        where this kind of result has no test report.
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
    report: Callable[[Mapping[str, Any], Document, Mapping[str, str]], Document] | None = None

    def write(self, result: Any, numbers: Mapping[str, Any], folder: Path, *, docx: bool = False) -> list[Path]:
        """Write page, Markdown, figures and further files into a folder, which is locked meanwhile.

        With `docx` the test report follows as a Word document.

        Returns
        -------
        list of Path
            The files, and the folder of the figures if it is separate.

        Raises
        ------
        UsageError
            The folder is not writable; or a Word document is wanted, and this kind of result has none, or python-docx
            is not installed.
        """
        from mechid.ink.on_page import document_page

        if docx:
            refuse_without_docx()
            self._refuse_without_report(result)

        with hold_folder(folder):
            own = self.files(result, numbers, folder)
            figures = self._write_figures(result, numbers, folder / self.figure_folder)
            texts, document = dict(self.texts(result, numbers)), self.document(numbers)
            if self.name:
                texts[f"{self.name}.md"] = document_markdown(document)
                texts[f"{self.name}.html"] = document_page(document, figures, self.style)
            own += write_together(folder, texts)
            if docx and self.report:
                # Written last: it holds the digests of the files beside it.
                report = self.report(numbers, document, text_digests(own))
                pictures = picture_files(folder / self.figure_folder, [*figures])
                own.append(write_docx(report, pictures, folder / f"{self.name}.docx"))
            if figures and self.figure_folder:
                return [*own, folder / self.figure_folder]
            return [*own, *(folder / f"{name}.svg" for name in figures)]

    def _refuse_without_report(self, result: Any) -> None:
        if self.report is None:
            raise UsageError(f"docx: no test report is made of a {type(result).__name__}; leave it out")

    def _write_figures(self, result: Any, numbers: Mapping[str, Any], folder: Path) -> Any:
        figures = iter(self.figures(result, numbers))
        first = next(figures, None)
        if first is None:
            return {}
        # Imported here, since Matplotlib takes half a second to load.
        from mechid.ink.figures import write_figures

        return write_figures(chain([first], figures), folder)

    def print(self, numbers: Mapping[str, Any], console: Console, files: Sequence[Path] = ()) -> None:
        """Print the document of `numbers` and the paths of its files."""
        print_document(self.document(numbers), console, files)

    def text(self, result: Any) -> str:
        """Return the text that the command prints for a result."""
        console = Console(file=io.StringIO(), width=TEXT_WIDTH, markup=False, highlight=False, emoji=False)
        self.print(self.numbers(result), console)
        assert isinstance(console.file, io.StringIO)
        return console.file.getvalue().rstrip("\n")

    def html(self, result: Any) -> str:
        """Return the same text as HTML for a notebook."""
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
