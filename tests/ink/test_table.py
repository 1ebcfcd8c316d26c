"""Tables of reports. Truth: the cells of tables written by hand."""

from mechid.ink.table import GROUP, Table, shown_columns
from mechid.ink.text_table import DOCX, MARKDOWN, TERMINAL, Column

COLUMNS = (Column("a", "a", words=True, where=(TERMINAL, DOCX)), Column("b", "b", where=(MARKDOWN,)), Column("c", "c"))
ROWS = [{GROUP: "gear", "a": "x", "b": "1", "c": "2"}]


def test_each_printer_has_its_own_columns():
    keys = {where: [column.key for column in shown_columns(COLUMNS, where)] for where in (TERMINAL, MARKDOWN, DOCX)}
    assert keys == {TERMINAL: ["a", "c"], MARKDOWN: ["b", "c"], DOCX: ["a", "c"]}


def test_groups_are_shown_where_a_table_names_them():
    assert Table(COLUMNS, ROWS, group="").is_grouped
    assert not Table(COLUMNS, ROWS).is_grouped
    assert not Table(COLUMNS, [{"a": "x", "b": "1", "c": "2"}], group="").is_grouped
    assert Table(COLUMNS, ROWS, group="part").markdown().splitlines()[2] == "| gear | 1 | 2 |"
