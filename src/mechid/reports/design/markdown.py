"""A design as Markdown."""

from __future__ import annotations

from mechid.ink.data import Data
from mechid.ink.markdown_text import bullets, synthetic_words
from mechid.reports.design.rivals import rival_lines
from mechid.reports.design.tables import loss_table, pair_table, parameter_table, record_table
from mechid.reports.design.verdict import RIVALS, headline, hole_lines, left_out_lines, loss_words, peak_lines


def design_markdown(data: Data) -> str:
    """Return the design's tables as Markdown."""
    parts = ["# Design of the next test", *synthetic_words(data), f"**{headline(data)}**"]
    if data["rivals"]:
        parts += [f"## {RIVALS}", bullets(rival_lines(data)), pair_table(data).markdown()]
    parts += ["## Standard errors", parameter_table(data).markdown()]
    parts += ["## Records, the most informative first", record_table(data).markdown()]
    parts += ["## Step loss", loss_words(data), loss_table(data).markdown()]
    for title, lines in (
        ("Rates at which steps are lost though higher ones hold", hole_lines(data)),
        ("Torque over the step rate", peak_lines(data)),
        ("Left out", left_out_lines(data)),
        ("Warnings", data["warnings"]),
    ):
        parts += [f"## {title}", bullets(lines)] if lines else []
    return "\n\n".join(parts) + "\n"
