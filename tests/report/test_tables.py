"""Truth: the fit made by hand."""

import json

import pytest

from mechid.identification.result.estimate_file import json_text
from mechid.reports import report_data
from mechid.reports.fit.tables import NAME, VALUE, stage_table
from mechid.reports.table import Table
from mechid.reports.text_table import Column, OnPage
from printing import printed


@pytest.fixture
def data(make_fit, truth):
    return report_data(make_fit(), truth, synthetic=True)


def row(data, name):
    return next(row for row in data["parameters"] if row["name"] == name)


def test_every_parameter_of_the_mechanism_is_there_once(data, make_fit):
    assert [row["name"] for row in data["parameters"]] == list(make_fit().mechanism.parameters)


def test_a_deviation_is_estimate_minus_truth_in_sigmas(data):
    assert row(data, "gear.stiffness")["deviation_sigmas"] == pytest.approx(-1.0)
    assert row(data, "gear.stiffness")["text"]["deviation_sigmas"] == "-1.0"


def test_an_angle_deviates_the_short_way_round(data):
    """179 deg is 2 deg below -179 deg, and sigma is 0.5 deg."""
    assert row(data, "stepper.detent.0.phase_deg")["deviation_sigmas"] == pytest.approx(-4.0)


def test_truth_is_shown_to_the_decimal_of_the_estimate(data):
    text = row(data, "stepper.coil_resistance")["text"]
    assert (text["estimate"], text["std_error"], text["truth"]) == ("9.923", "0.012", "9.900")


def test_known_parameters_are_told_from_estimated_ones(data):
    assert not row(data, "stepper.poles")["estimated"]
    assert row(data, "stepper.back_emf_constant")["estimated"]
    assert row(data, "friction.static")["text"]["status"] == "at bound"


def test_the_report_without_truth_has_no_deviation(make_fit):
    data = report_data(make_fit())
    assert not data["has_truth"]
    assert not data["synthetic"]
    assert all(row["truth"] is None and row["deviation_sigmas"] is None for row in data["parameters"])


def test_it_is_strict_json_with_null_for_what_is_not_finite(data):
    read = json.loads(json_text(data), parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert read["records"][1]["fit_percent"] is None
    assert read["records"][1]["text"]["fit_percent"] == "-"
    assert read["stages"][0]["cost"] is None
    assert read["provenance"]["wall_time_s"] == 1.5


def test_every_record_is_validated_in_the_dict(make_fit, validation):
    data = report_data(make_fit(), validation=validation)
    assert [(row["name"], row["use"]) for row in data["validation"]] == [("full_46", "estimate"), ("sweep", "validate")]
    assert data["validation"][1]["text"]["theil"] == "0.0182"
    assert data["validation"][1]["text"]["bias"] == "0.000"
    assert data["orders"][0]["text"]["phase_error_deg"] == "-"
    assert data["orders"][1]["text"]["amplitude_error_percent"] == "1.9"
    json.loads(json_text(data))


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
