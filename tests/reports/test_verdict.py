"""The verdict. Truth: reports written by hand, of which the right answer is known."""

import copy

import pytest

from mechid.identification.result.grade import GRADE_WORDS
from mechid.reports.verdict import BAD, CAUTION, GOOD, summary_data


def parameter(name, estimate, sigma, *, unit="N m", status="free", white=None, reason=""):
    text = {"estimate": f"{estimate:g}", "std_error": f"{sigma or 0:g}", "unit": unit, "status": status}
    return {
        "name": name,
        "estimate": estimate,
        "std_error": sigma,
        "std_error_noise": sigma,
        "std_error_white": white or sigma,
        "unit": unit,
        "local_only": False,
        "status": status,
        "reason": reason,
        "text": text,
    }


@pytest.fixture
def data():
    """Return a report of a good fit: one record explained, one held out, two parameters."""
    bands = [{"centre_hz": 50.0, "residual_rms": 0.001}, {"centre_hz": 1000.0, "residual_rms": 0.004}]
    validation = [
        {
            "name": n,
            "use": use,
            "left_out": False,
            "quantity": "torque",
            "residual_rms": 0.00201,
            "samples": 10_001,
            "effective_samples": 9950.0,
            "bands": bands,
            "text": {"fit_percent": "99.2"},
        }
        for n, use in (("full_46", "estimate"), ("sweep", "validate"))
    ]
    return {
        "grade": "A",
        "grade_words": GRADE_WORDS["A"],
        "reasons": [],
        "outcome": {"message": "It has converged."},
        "validation": validation,
        "channels": [],
        "records": [{"name": n, "noise_known": 0.002} for n in ("full_46", "sweep")],
        "parameters": [
            parameter("gear.stiffness", 913.0, 0.9),
            parameter("friction.static", 0.008, 0.0004),
            parameter("stepper.detent.0.phase_deg", 35.0, 0.3, unit="deg"),
        ],
        "warnings": [],
        "lacking": [],
        "correlation": {"names": ["a", "b"], "matrix": [[1.0, 0.97], [0.97, 1.0]]},
        "information": {
            "parameters": ["gear.stiffness", "friction.static"],
            "records": ["full_46", "sweep"],
            "duration_s": [1.0, 60.0],
            "repeated": [[0.9, 0.9], [0.9, 0.75]],
        },
    }


def answers(data, number):
    return " ".join(summary_data(data)["questions"][number]["answers"])


def test_a_good_fit_is_called_good(data):
    assert summary_data(data)["tone"] == GOOD
    assert "2 of 2 records are explained down to their noise" in answers(data, 0)
    assert "Record sweep was held out and is predicted with a fit of 99.2 %" in answers(data, 0)


@pytest.mark.parametrize(("grade", "tone"), [("B", CAUTION), ("C", BAD), ("failed", BAD)])
def test_a_lower_grade_is_said_with_its_reason_and_what_to_do_and_explains_nothing_down_to_the_noise(data, grade, tone):
    """Truth: the same residuals, of the size of the noise, under a grade of a model that is not complete."""
    reason = {"text": "gear.stiffness is held at 2000.", "next_command": "mechid identify bench --out DIR"}
    data |= {"grade": grade, "grade_words": GRADE_WORDS[grade], "reasons": [reason]}
    found = summary_data(data)
    assert (found["grade"], found["tone"], found["headline"]) == (grade, tone, GRADE_WORDS[grade])
    assert answers(data, 0).startswith("It has converged. gear.stiffness is held at 2000. The residual is 1.01 to 1.01")
    assert "explained" not in answers(data, 0)
    assert answers(data, 2).startswith("Next: mechid identify bench --out DIR.")


def test_a_misfit_is_named_with_its_size_and_band(data):
    data["validation"] = copy.deepcopy(data["validation"])
    data["validation"][0]["residual_rms"] = 0.0064
    assert summary_data(data)["tone"] == CAUTION
    line = "Record full_46: the residual is 3.20 times the noise floor, most of it in the third octave at 1000 Hz."
    assert line in answers(data, 0)
    assert "what record full_46 still contains" in answers(data, 2)


@pytest.mark.parametrize(
    ("effective", "said"),
    [
        (9950.0, "1.16 times the noise floor, where chance explains up to 1.07 with 9950 effective samples."),
        (31.0, "1.16 times the noise floor, and coloured: 10001 samples worth 31 effective ones, by chance up to 1.2."),
    ],
)
def test_a_sixth_above_the_floor_is_no_noise_in_ten_thousand_samples(data, effective, said):
    """Truth: the RMS of 10 001 independent samples scatters by 0.7 %, the floor by 1.7 %: 16 % is no chance.

    Nor is a residual of few effective samples white noise, whose size is that of the floor.
    """
    data["validation"][0] |= {"residual_rms": 0.00232, "effective_samples": effective}
    assert summary_data(data)["tone"] == CAUTION
    assert "1 of 2 records are explained down to their noise" in answers(data, 0)
    assert f"Record full_46: the residual is {said}" in answers(data, 0)
    assert "what record full_46 still contains" in answers(data, 2)


def test_a_simulation_that_fails_is_said(data):
    data["validation"][1] = data["validation"][1] | {"residual_rms": float("nan"), "bands": []}
    assert summary_data(data)["tone"] == CAUTION
    assert "Record sweep: the simulation does not come to its end." in answers(data, 0)


@pytest.mark.parametrize("status", ["at_bound", "frozen"])
def test_what_has_no_sigma_is_named(data, status):
    data["parameters"].append(parameter("gear.damping", 5.0, None, status=status, reason="no record sees it"))
    assert summary_data(data)["tone"] == CAUTION
    assert "no record sees it" in answers(data, 1)


def test_the_least_certain_is_the_largest_relative_error(data):
    """5 % of static friction; 0.1 % of stiffness; 0.3 deg, 0.0052 rad, of a phase."""
    assert answers(data, 1).startswith("friction.static = 0.008 ± 0.0004 N m (5.0 %).")
    assert "a and b depend on each other most: correlation +0.970" in answers(data, 1)


def test_the_record_that_helps_most_is_named_and_the_one_that_does_by_the_second(data):
    """0.75 with 60 s, 0.9 with 1 s."""
    text = answers(data, 2)
    assert "Recording sweep once more (60 s) would lower the standard error of friction.static by 25 %." in text
    assert "Per second of test full_46 (1 s) helps most: 10.0 %." in text


def test_a_record_that_does_not_help_is_not_proposed(data):
    data["information"]["repeated"][1] = [0.995, 0.999]
    assert "No single record repeated" in answers(data, 2)


def test_coloured_residuals_are_said(data):
    data["parameters"][0]["std_error_white"] = 0.3
    assert summary_data(data)["tone"] == CAUTION
    assert summary_data(data)["headline"] == f"{GRADE_WORDS['A']} Read the cautions before its values are used."
    assert "coloured" in answers(data, 1)


def test_errors_that_hold_on_one_side_of_a_threshold_are_said(data):
    data["parameters"][0]["local_only"] = True
    assert summary_data(data)["tone"] == CAUTION
    said = "Near a stick/slip threshold: the standard errors of gear.stiffness hold on this side of it only."
    assert said in answers(data, 1)


def test_a_record_that_was_left_out_against_its_file_is_not_called_held_out(data):
    """Truth: the file gives it to estimate from; it is no test of the prediction, nor a model's lack."""
    data["validation"][1] |= {"left_out": True, "residual_rms": 0.2, "text": {"fit_percent": "-312"}}
    text = answers(data, 0)
    assert "Record sweep was left out of the fit, although the campaign file gives it to estimate from" in text
    assert "fit of -312 %" in text
    assert "Record sweep was held out" not in text
    assert "No record was held out" in text
    assert "still contains" not in answers(data, 2)
    assert "Knowing how record sweep was commanded and wired" in answers(data, 2)


def test_no_held_out_record_is_said(data):
    data["validation"] = data["validation"][:1]
    assert "No record was held out" in answers(data, 0)


def test_without_information_or_errors_it_still_answers(data):
    data |= {"information": None, "parameters": [], "correlation": {"names": [], "matrix": []}}
    assert answers(data, 1) == "No parameter has a standard error."
    assert answers(data, 2)
