"""The tables of a fit's report. Truth: the rows that are handed to them."""

from mechid.diagnoses.effect_rows import NAME, VALUE
from mechid.ink.table import Table
from mechid.ink.text_table import Column, OnPage
from mechid.reports.tables import stage_table
from printing import printed

ROWS = [
    {
        "name": "K_s|x",
        "words": "a <term>",
        "term": "gear.backlash",
        "meaning": "a gap",
        "text": {"value": "2.7", "std_error": "0.1", "unit": "rad"},
    },
    {
        "name": "b",
        "words": "a <term>",
        "term": "gear.backlash",
        "meaning": "a width",
        "text": {"value": "3", "std_error": "0.2", "unit": "rad"},
    },
]
CELLS = ("2.7", "0.1", "rad", "a gap", "3", "0.2", "a width")


def test_a_tables_three_printers_have_every_cell_of_it():
    """Truth: the rows; what is markup in a form is escaped there, and the group stands once or in each line."""
    meaning = Column("meaning", "meaning", words=True, on_page=OnPage(wide=True))
    rows = [{**row, "table": f"{row['words']} ({row['term']})"} for row in ROWS]
    table = Table((NAME, *VALUE, meaning), rows, group="term")
    terminal = printed(Table.print, table, 120)
    markdown, page = table.markdown(), table.html()
    assert all(cell in terminal and f" {cell} " in markdown and f">{cell}</td>" in page for cell in CELLS)
    assert ["a <term> (gear.backlash)" in terminal, terminal.count("gear.backlash")] == [True, 1]
    assert [line.count("gear.backlash") for line in markdown.splitlines()] == [0, 0, 1, 1]
    assert page.count("a &lt;term&gt; (gear.backlash)") == 1
    assert ["K_s|x" in terminal, r"K\_s\|x" in markdown, ">K_s|x</th>" in page] == [True, True, True]
    assert [header in markdown.splitlines()[0] for header in ("term", "± σ", "meaning")] == [True, True, True]


def test_a_column_for_pages_is_on_pages_alone():
    row = {
        "name": "joint fit",
        "note": "stopped",
        "text": dict.fromkeys(("records", "record_s", "free", "cost", "evaluations", "seconds"), "1"),
    }
    table = stage_table([row])
    assert "stopped" in table.html()
    assert "stopped" not in table.markdown()
