"""Option ``--docx`` of commands that have a test report."""

from __future__ import annotations

from typing import Annotated, TypeAlias

import typer

Docx: TypeAlias = Annotated[
    bool, typer.Option("--docx", help="Also the test report as a Word document (extra office).")
]
