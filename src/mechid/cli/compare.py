"""``mechid compare``: comparison of hypotheses on the same records."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def compare(
    fits: Annotated[list[Path], typer.Argument(metavar="FIT FIT...", help="Result folders of mechid identify.")],
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Folder for comparison.json.")] = None,
) -> None:
    """Compare finished fits of the same records."""
    from mechid.cli.output import print_result
    from mechid.comparisons.run import compare as compared

    print_result(compared(*fits), out)
