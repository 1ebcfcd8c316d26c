"""Every number of a fit. Truth: the fit made by hand."""

import json

import pytest

from mechid.identification.result.estimate_file import json_text
from mechid.reports.numbers import report_data


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
