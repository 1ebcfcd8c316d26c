"""The path of a completed mechanism, as every form of a report shows it."""

import json
from dataclasses import replace

import pytest

from mechid.diagnoses.path import COMPLETED_TITLE, PATH_COLUMNS, completed_data, path_rows, path_table
from mechid.ink.in_markdown import document_markdown
from mechid.ink.on_page import interactive_page
from mechid.reports.document import PRESENTER
from mechid.reports.figure_cache import page_script
from mechid.reports.numbers import report_data
from mechid.reports.sections import report_document
from printing import printed

STEPS = (
    {
        "step": 1,
        "added": "friction.stribeck",
        "removed": "",
        "cost": 3.0e4,
        "bic": 25210.4,
        "over_noise": 1.21,
        "free": 17,
    },
    {"step": 2, "added": "", "removed": "gear.backlash", "cost": 2.1e4, "bic": 20144.6, "over_noise": 1.0, "free": 16},
)
TEXTS = [
    {"step": "1", "what": "friction.stribeck added", "over_noise": "1.210", "free": "17", "bic": "25210"},
    {"step": "2", "what": "gear.backlash removed", "over_noise": "1.000", "free": "16", "bic": "20145"},
]


def test_a_row_for_each_step():
    """Truth: the steps."""
    assert [row["text"] for row in path_rows(STEPS)] == TEXTS
    first, *others = path_rows(STEPS, {"cost": 9e4, "bic": 80000.0, "over_noise": 1.9, "free": 15})
    assert first["text"]["what"] == "the mechanism as written"
    assert [row["text"] for row in others] == TEXTS


def test_steps_of_an_earlier_version_lack_what_they_lack():
    (row,) = path_rows([{"step": 1, "added": "clock", "removed": "", "cost": 1.0, "bic": 2.0}])
    assert (row["text"]["over_noise"], row["text"]["free"], row["text"]["bic"]) == ("-", "-", "2")


@pytest.mark.parametrize("steps", [None, (), STEPS])
def test_report_and_terminal_show_it(make_fit, steps):
    """Truth: the steps; nobody who has not asked for completion is told of it."""
    data = report_data(replace(make_fit(), completed=steps))
    assert data["completed"] == completed_data(steps)
    text = printed(PRESENTER.print, data, 120)
    assert (COMPLETED_TITLE in text) == (steps is not None)
    assert ("nothing was added" in text) == (steps == ())
    assert all(cell in text for row in TEXTS for cell in row.values()) == (steps == STEPS)


@pytest.mark.parametrize("steps", [None, (), STEPS])
def test_markdown_and_page_show_it(reported, steps):
    """Truth: the steps, and the report's own dict for the rest."""
    data = json.loads((reported.folder / "report.json").read_text(encoding="utf-8"))
    data["completed"] = completed_data(steps)
    document = report_document(data)
    for text in (document_markdown(document), "".join(interactive_page(document, {}, page_script([], [])))):
        assert (COMPLETED_TITLE in text) == (steps is not None)
        assert all(cell in text for row in TEXTS for cell in row.values()) == (steps == STEPS)


def test_a_table_on_a_page_has_every_cell():
    table = path_table(path_rows(STEPS)).html()
    assert all(f">{cell}<" in table for row in TEXTS for cell in row.values())
    assert all(f">{column.header}<" in table for column in PATH_COLUMNS)
