"""``mechid open``: index page of all results below a folder."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer


def open_index(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Below which results lie, as an --out or above it.")],
    browser: Annotated[
        bool | None,
        typer.Option("--browser/--no-browser", help="Open the page in a browser; so on a terminal, not in a script."),
    ] = None,
) -> None:
    """Write index.html: a card for each result below a folder, what is out of date, links to all pages."""
    from mechid.cli.output import print_result
    from mechid.indexes.run import open_results

    print_result(open_results(folder, browser=sys.stdout.isatty() if browser is None else browser), None)
