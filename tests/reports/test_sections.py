"""Truth: every name and number of the report's dict stands in what is printed, whole."""

from dataclasses import replace

import pytest

from mechid.identification.output_error.declaration import Reading
from mechid.identification.result.grade import GRADE_WORDS, Cause, FitOutcome, Grade, Reason
from mechid.reports.document import PRESENTER
from mechid.reports.numbers import report_data
from printing import printed, tables

ESCAPE = "\x1b"


@pytest.mark.parametrize("width", [80, 120, 200])
def test_nothing_is_cut(make_fit, truth, width):
    data = report_data(make_fit(), truth, synthetic=True)
    text = printed(PRESENTER.print, data, width)
    words = text.split()
    assert "…" not in text
    for row in (*(p for p in data["parameters"] if p["estimated"]), *data["records"], *data["stages"]):
        name = row["key"] if "key" in row else row["name"]
        for cell in (name, *row["text"].values()):
            assert all(word in words for word in cell.split()), (name, cell)


@pytest.mark.parametrize("width", [80, 200])
def test_tables_stay_within_the_width(make_fit, truth, width):
    text = printed(PRESENTER.print, report_data(make_fit(), truth, synthetic=True), width)
    assert max(len(line) for table in tables(text) for line in table) <= width


def test_a_wide_console_gets_one_table_of_parameters_a_narrow_one_two(make_fit, truth):
    data = report_data(make_fit(), truth)
    count = {width: len(tables(printed(PRESENTER.print, data, width))) for width in (80, 200)}
    assert count[200] == 3
    assert count[80] > count[200]


@pytest.mark.parametrize("width", [80, 120])
def test_records_held_out_are_shown_and_no_others(make_fit, validation, width):
    """Truth: the validation made by hand; the record that was estimated from has its line elsewhere."""
    data = report_data(make_fit(), validation=validation)
    text = printed(PRESENTER.print, data, width)
    shown = text[text.index("Prediction of the records held out") : text.index("Stages")]
    assert "full_46" not in shown
    for row in (data["validation"][1], data["orders"][1]):
        assert all(cell in shown.split() for cell in row["text"].values() if cell)
    assert max(len(line) for table in tables(text) for line in table) <= width


def test_without_records_held_out_there_is_no_such_table(make_fit, validation):
    del validation["sweep"]
    assert "held out" not in printed(PRESENTER.print, report_data(make_fit(), validation=validation), 120)


def test_a_record_left_out_of_the_fit_is_said_so_and_not_called_held_out(make_fit, validation):
    """Truth: the record's entry says that the fit left it out; the campaign file gives it to estimate from."""
    fit = make_fit()
    sweep = replace(fit.records["sweep"], reading=Reading(left_out=True))
    data = report_data(replace(fit, records={**fit.records, "sweep": sweep}), validation=validation)
    text = printed(PRESENTER.print, data, 160)
    assert "held out" not in text
    assert "Records to estimate from that were left out, because they contradict the others; residual in N m" in text
    assert next(line.split()[:3] for line in text.splitlines() if line.startswith("sweep")) == ["sweep", "left", "out"]


def test_a_long_name_runs_over_rather_than_being_cut(make_fit):
    data = report_data(make_fit())
    name = "a_record_with_a_name_that_no_terminal_of_eighty_columns_would_ever_hold_in_any_of_its_lines"
    data["records"][0]["name"] = name
    assert name in printed(PRESENTER.print, data, 80)


def test_a_log_has_no_codes_and_only_plain_characters(make_fit, truth):
    text = printed(PRESENTER.print, report_data(make_fit(), truth, synthetic=True), 80)
    assert ESCAPE not in text
    assert text.isascii()


def test_a_terminal_has_colour(make_fit):
    data = report_data(make_fit(Grade.C))
    assert ESCAPE in printed(PRESENTER.print, data, 80, terminal=True)


@pytest.mark.parametrize("grade", list(Grade))
def test_the_grade_comes_first_its_reasons_next(make_fit, grade):
    reason = Reason(cause=Cause.LEFT_OUT, text="Record sweep was left out.", next_command="mechid check bench")
    lines = printed(PRESENTER.print, report_data(make_fit(grade, (reason,))), 120).splitlines()
    said = ["record left out: Record sweep was left out.", "next: mechid check bench", FitOutcome.CONVERGED.value]
    cautions = " Read the cautions before its values are used." if grade is Grade.A else ""
    assert lines[:4] == [f"{GRADE_WORDS[grade]}{cautions}", *said]


def test_what_is_wrong_with_the_files_comes_before_other_reasons(make_fit):
    """Truth: what concerns all first, then bounds, then single records, then the rest."""
    value = Reason(cause=Cause.VALUE_CONTRADICTED, text="A value.", next_command="correct it")
    bound = Reason(cause=Cause.BOUND_CONTRADICTED, text="A bound.", next_command="widen it")
    other = Reason(cause=Cause.USED_IN_PART, text="In part.", next_command="look")
    warnings = ("record sweep: late", "all records: alike", "gear.stiffness: whatever")
    fit = replace(make_fit(Grade.C, (other, value, bound)), warnings=warnings)
    lines = printed(PRESENTER.print, report_data(fit), 120).splitlines()
    assert lines[1:9] == [
        "warning: all records: alike",
        "value contradicted: A value.",
        "next: correct it",
        "bound contradicted: A bound.",
        "next: widen it",
        "warning: record sweep: late",
        "followed in part: In part.",
        "next: look",
    ]


def test_synthetic_is_said_before_anything_else(make_fit, truth):
    text = printed(PRESENTER.print, report_data(make_fit(), truth, synthetic=True), 80)
    assert text.startswith("SYNTHETIC")


def test_warnings_notes_and_files_are_lines_of_their_own(make_fit, tmp_path):
    data = report_data(make_fit())
    lines = printed(PRESENTER.print, data, 80, files=[tmp_path / "estimate.json"]).splitlines()
    assert f"warning: {data['warnings'][0]}" in lines
    assert f"note: {data['notes'][0]}" in lines
    assert f"written: {tmp_path / 'estimate.json'}" in lines
