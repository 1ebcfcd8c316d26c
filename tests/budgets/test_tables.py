"""The tables of a budget. Truth: the dict of its numbers."""

import io
import re

from rich.console import Console

from mechid.budgets.document import PRESENTER
from mechid.budgets.texts import add_texts


def test_the_tables_of_terminal_and_markdown_print_in_bold_what_decides(data, report):
    """Truth: the dict's own numbers; rows in the dict's order."""
    deciding = [row["text"]["deciding"] for row in add_texts(data)["requirements"]]
    text = (report / "budget.md").read_text(encoding="utf-8")
    rows = re.findall(r"^[|].*$", text.split("## Requirements")[1].split("##")[0], re.MULTILINE)
    assert re.findall(r"[*][*](.*?)[*][*]", "\n".join(rows)) == deciding
    console = Console(width=300, force_terminal=True, file=io.StringIO())
    PRESENTER.print(data, console)
    rows = re.findall(r"^(?:met|not sure|exceeded) .*$", console.file.getvalue(), re.MULTILINE)
    bold = [re.findall(r"\x1b\[1m *([-0-9.]+)\x1b", row) for row in rows]
    assert bold == [[one] for one in deciding]
