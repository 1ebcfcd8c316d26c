"""The tables of a budget. Truth: the dict of its numbers."""

import io
import re

from rich.console import Console

from mechid.reports.budget.contents import budget_contents
from mechid.reports.budget.terminal import print_budget


def test_the_tables_of_terminal_and_markdown_print_in_bold_what_decides(data, folder):
    """Truth: the dict's own numbers; rows in the dict's order."""
    deciding = [row["text"]["deciding"] for row in budget_contents(data)["requirements"]]
    text = (folder / "budget.md").read_text(encoding="utf-8")
    table = text.split("## Requirements")[1].split("##")[0]
    assert re.findall(r"[*][*](.*?)[*][*]", table) == deciding
    console = Console(width=300, force_terminal=True, file=io.StringIO())
    print_budget(data, console)
    rows = re.findall(r"^(?:met|not sure|exceeded) .*$", console.file.getvalue(), re.MULTILINE)
    bold = [re.findall(r"\x1b\[1m *([-0-9.]+)\x1b", row) for row in rows]
    assert bold == [[one] for one in deciding]
