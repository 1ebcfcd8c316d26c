"""Tables in Word. Truth: the cells of tables written by hand, and the width of a page."""

import pytest
from docx import Document
from docx.oxml import parse_xml
from docx.oxml.ns import nsdecls, qn
from docx.table import Table as WordTable

import word_files
from mechid.ink.docx_table import SIZES, Cell, facts_block, grid_of, table_blocks
from mechid.ink.table import Table
from mechid.ink.text_table import DOCX, TERMINAL, Column, OnPage

WIDTH_PT = 480.0
DIGEST = 8 * "0123abcd"


def shown(block):
    """Return a block as a table of python-docx."""
    (tbl,) = parse_xml(f"<w:body {nsdecls('w')}>{block}</w:body>")
    return WordTable(tbl, Document()._body)


def width_of(block):
    """Return the width of a table in points."""
    return sum(int(column.get(qn("w:w"))) for column in shown(block)._tbl.iter(qn("w:gridCol"))) / 20.0


def wide(columns, rows):
    """Return a table of words that are too long for a page together."""
    own = [Column(f"column {k}", f"c{k}", words=k == 0) for k in range(columns)]
    return Table(own, [{f"c{k}": f"value_{row}_{k}_{12 * 'x'}" for k in range(columns)} for row in range(rows)])


def test_a_table_that_fits_is_one_table_as_wide_as_needed():
    table = Table((Column("name", "name", words=True), Column("Hz", "hz")), [{"name": "tilt", "hz": "12.5"}])
    (block,) = table_blocks(table, WIDTH_PT)
    assert word_files.cells(shown(block)) == [["name", "Hz"], ["tilt", "12.5"]]
    assert width_of(block) < 0.5 * WIDTH_PT
    alignments = [p.alignment for row in shown(block).rows for cell in row.cells for p in cell.paragraphs]
    assert [str(a).split(" ")[0] for a in alignments] == ["LEFT", "RIGHT", "LEFT", "RIGHT"]


def test_only_its_own_columns_are_shown_and_no_empty_ones():
    columns = (Column("a", "a", where=(TERMINAL,)), Column("b", "b", where=(DOCX,)), Column("c", "c"))
    grid = grid_of(Table(columns, [{"a": "1", "b": "2", "c": " "}]))
    assert grid.heads == ["b"]
    assert grid.rows == [[Cell("2")]]


def test_rows_of_a_group_stand_under_its_name():
    rows = [{"table": name, "a": k, "b": k} for k, name in enumerate(("gear", "gear", "load"))]
    (block,) = table_blocks(Table((Column("a", "a"), Column("b", "b")), rows, group=""), WIDTH_PT)
    assert word_files.cells(shown(block)) == [
        ["a", "b"],
        ["gear", "gear"],  # one cell over both columns
        ["0", "0"],
        ["1", "1"],
        ["load", "load"],
        ["2", "2"],
    ]


def test_cells_are_coloured_by_their_strength():
    """Truth: the colours of a page in print at opacities of 0.75 and 0.38 over white."""
    columns = (Column("a", "a", on_page=OnPage(heat=lambda row: row["heat"])),)
    grid = grid_of(Table(columns, [{"a": "x", "heat": heat} for heat in (0.0, 1.0, -0.5)]))
    assert [row[0].fill for row in grid.rows] == ["", "4885C2", "E7BA9E"]


def test_a_wide_table_of_few_rows_is_turned():
    (block,) = table_blocks(wide(9, 3), WIDTH_PT)
    made = word_files.cells(shown(block))
    assert made[0] == ["column 0", *(f"value_{row}_0_{12 * 'x'}" for row in range(3))]
    assert len(made) == 9
    assert width_of(block) <= WIDTH_PT


def test_a_wide_table_of_many_rows_is_divided_and_repeats_its_first_column():
    blocks = table_blocks(wide(9, 6), WIDTH_PT)
    assert len(blocks) > 1
    parts = [word_files.cells(shown(block)) for block in blocks]
    assert {part[0][0] for part in parts} == {"column 0"}
    assert [head for part in parts for head in part[0][1:]] == [f"column {k}" for k in range(1, 9)]
    assert all(len(part) == 7 for part in parts)
    assert max(map(width_of, blocks)) <= WIDTH_PT


def test_the_parts_of_a_divided_table_are_of_one_size():
    names = [f"column_{k}" for k in range(13)]
    blocks = table_blocks(Table([Column(name, name) for name in names], [dict.fromkeys(names, "0")] * 6), WIDTH_PT)
    assert [len(word_files.cells(shown(block))[0]) for block in blocks] == [7, 7]


def test_a_digest_is_broken_rather_than_the_table():
    table = Table([Column(str(k), str(k), words=True) for k in range(3)], [{"0": "a", "1": "b", "2": DIGEST}])
    (block,) = table_blocks(table, 0.5 * WIDTH_PT)
    assert width_of(block) <= 0.5 * WIDTH_PT
    assert word_files.cells(shown(block))[1] == ["a", "b", DIGEST]


@pytest.mark.parametrize(("columns", "size"), [(4, SIZES[0]), (8, SIZES[-1])])
def test_letters_become_smaller_before_a_table_is_divided(columns, size):
    names = [f"c{k}" for k in range(columns)]
    table = Table([Column(name, name) for name in names], [dict.fromkeys(names, 13 * "0")] * 6)
    (block,) = table_blocks(table, WIDTH_PT)
    sizes = {run.font.size.pt for row in shown(block).rows for cell in row.cells for run in cell.paragraphs[0].runs}
    assert sizes == {0.5 * size}


@pytest.mark.parametrize(("rows", "kept"), [(5, True), (20, False)])
def test_a_short_table_stays_on_one_page(rows, kept):
    (block,) = table_blocks(Table((Column("a", "a"), Column("b", "b")), [{"a": 1, "b": 2}] * rows), WIDTH_PT)
    keeps = [bool(row.cells[0].paragraphs[0].paragraph_format.keep_with_next) for row in shown(block).rows]
    assert keeps == [True, *([kept] * (rows - 1)), False]


def test_facts_have_no_header():
    made = shown(facts_block([("date", "2026-04-02")], WIDTH_PT))
    assert word_files.cells(made) == [["date", "2026-04-02"]]
    assert not word_files.repeats(made.rows[0])
