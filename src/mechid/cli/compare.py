"""``mechid compare``: which of several hypotheses the same records prefer."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def compare(
    fits: Annotated[list[Path], typer.Argument(metavar="FIT FIT...", help="Result folders of mechid identify.")],
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Folder for comparison.json.")] = None,
) -> None:
    """Compare finished fits of the same records."""
    from contextlib import nullcontext

    from mechid.analysis import compare as compare_fits
    from mechid.holding import held
    from mechid.reports.comparison import comparison_data, print_comparison, write_comparison
    from mechid.reports.terminal import console_on

    data = comparison_data(compare_fits(*fits))
    with held(out) if out else nullcontext():
        print_comparison(data, console_on(), [write_comparison(data, out)] if out else [])
