"""Report of a budget. Truth: the dict of its numbers."""

import pytest

from mechid.budgets.document import PRESENTER
from mechid.budgets.texts import requirement_text
from mechid.ink.document import Rows, Section
from mechid.ink.in_markdown import document_markdown


@pytest.fixture(scope="module")
def report(data):
    return PRESENTER.report(data, PRESENTER.document(data), {"budget.json": 64 * "b"})


def rows_under(document, heading):
    (section,) = [part for part in document.parts if isinstance(part, Section) and part.heading == heading]
    return [part.table.rows for part in section.parts if isinstance(part, Rows)]


def test_the_verification_table_has_each_requirement_in_each_mode(report, data):
    (rows,) = rows_under(report, "Verification")
    assert len(rows) == len(data["requirements"])
    for row, one in zip(rows, data["requirements"], strict=True):
        text = requirement_text(one)
        assert row["requirement"].startswith(f"{one['requirement']}, {one['mode']} (")
        assert row["value"].startswith(text["level"])
        assert (row["limit"], row["margin"], row["verdict"]) == (
            f"{text['limit']} rad",
            f"{100.0 * one['decided']['margin95'][0]:.1f} %",
            text["met"],
        )
        assert data["provenance"]["fit"]["mechanism_sha256"][:16] in row["evidence"]


def test_it_names_the_files_and_the_records_that_it_rests_on(report, data):
    runs, files = rows_under(report, "Records")
    assert [row["name"] for row in runs] == [one["name"] for one in data["fit"]["records"]] == ["sweep"]
    assert {"budget.toml", "structure.toml"} <= {row["file"] for row in files}
    assert {row["file"]: row["sha256"] for row in files}["budget.toml"] == data["provenance"]["inputs_sha256"][
        "budget.toml"
    ]


def test_what_is_not_met_and_every_warning_is_a_deviation(report, data):
    text = document_markdown(report).split("## Deviations")[1].split("\n## ")[0]
    missed = [one for one in data["requirements"] if not one["decided"]["met"]]
    assert missed
    for one in missed:
        assert f"- {one['requirement']}, {one['mode']}: {requirement_text(one)['met']}." in text
    assert text.count("\n- ") == len(missed) + len(data["notes"]) + len(data["warnings"])


def test_what_the_fit_declares_of_its_test_is_shown(data):
    changed = {**data, "fit": {**data["fit"], "test": {"article": {"name": "SADM-200"}}}}
    text = document_markdown(PRESENTER.report(changed, PRESENTER.document(changed), {}))
    assert "- name: **SADM-200**" in text
