"""Truth: the contract of estimate.json, and JSON itself, which knows no NaN."""

import json
import math

import pytest

from mechid.errors import InputFileError
from mechid.identification.result.estimate_file import json_text, read_estimate


def test_what_is_not_finite_is_null():
    value = {"a": math.nan, "b": [math.inf, 1.5, -math.inf], "c": {"d": (1, None)}, "e": True, "f": "text"}
    read = json.loads(json_text(value), parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert read == {"a": None, "b": [None, 1.5, None], "c": {"d": [1, None]}, "e": True, "f": "text"}


@pytest.mark.parametrize("digits", [0.1, 1 / 3, 2.5e-300, -1.7976931348623157e308])
def test_numbers_keep_their_last_bit(digits):
    assert json.loads(json_text({"x": digits}))["x"] == digits


@pytest.mark.parametrize(
    ("content", "fragment"),
    [
        ('{"format": "mechid-estimate/9"}', 'found "mechid-estimate/9"; this mechid reads "mechid-estimate/1"'),
        ("{}", "format: found null"),
        ("[]", "is not an estimate: found [], no table"),
        ('"text"', 'found "text"'),
        ("{", "is damaged"),
    ],
)
def test_a_file_that_is_no_estimate_is_refused(tmp_path, content, fragment):
    path = tmp_path / "estimate.json"
    path.write_text(content)
    with pytest.raises(InputFileError, match=r"estimate\.json") as error:
        read_estimate(path)
    assert fragment in str(error.value)


def minimal():
    return {
        "format": "mechid-estimate/1",
        "outcome": {"code": "converged"},
        "parameters": {"gear.damping": {"value": 0.39, "status": "free"}},
        "correlation": {"names": ["gear.damping"], "matrix": [[1.0]]},
        "covariance": {"names": ["gear.damping"], "matrix": [[1e-6]]},
        "records": {},
        "provenance": {},
    }


def of_gear(**entries):
    """Return what spoils the table of the one parameter."""
    return lambda estimate: estimate["parameters"]["gear.damping"].update(entries)


DAMAGES = {
    "a value that is no number": (of_gear(value="0.39"), 'parameters.gear.damping.value: found "0.39"'),
    "a value that is not finite": (of_gear(value=float("nan")), "value: found NaN"),
    "a value that is null": (of_gear(value=None), "value: found null"),
    "no status": (of_gear(status=None), "parameters.gear.damping.status: missing"),
    "no parameters": (lambda e: e.pop("parameters"), "parameters: missing"),
    "no outcome": (lambda e: e["outcome"].clear(), "outcome.code: missing"),
    "a grade that is none": (lambda e: e.update(grade="Z"), 'grade: found "Z", expected one of A, B, C, failed'),
    "a matrix that is null": (lambda e: e.update(correlation=None), "correlation: found null, expected a table"),
    "a matrix that is a list": (lambda e: e.update(covariance=[]), "covariance: found [], expected a table"),
    "a matrix over no parameter": (lambda e: e["correlation"].update(names=["x"]), 'correlation.names: found "x"'),
    "a matrix over what is no name": (lambda e: e["correlation"].update(names=[[2]]), "correlation.names: found [2]"),
    "a matrix of texts": (
        lambda e: e["covariance"].update(matrix=[["x"]]),
        'covariance.matrix: found "x", expected a number',
    ),
    "a matrix of another size": (
        lambda e: e["covariance"].update(matrix=[[1.0, 2.0]]),
        "covariance.matrix: is not 1 x",
    ),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_damage_is_named_with_its_place(tmp_path, damage):
    """Truth: the same content without the damage is read."""
    path, content = tmp_path / "estimate.json", minimal()
    path.write_text(json.dumps(content))
    assert read_estimate(path) == content
    spoil, says = DAMAGES[damage]
    spoil(content)
    path.write_text(json.dumps(content))
    with pytest.raises(InputFileError, match="identify anew") as error:
        read_estimate(path)
    assert says in str(error.value)


def test_a_file_where_the_folder_should_be_is_told(tmp_path):
    (tmp_path / "fit").write_text("")
    with pytest.raises(InputFileError, match="fit is not a folder"):
        read_estimate(tmp_path / "fit" / "estimate.json")


def test_a_missing_file_is_refused_with_a_remedy(tmp_path):
    with pytest.raises(InputFileError, match="mechid identify"):
        read_estimate(tmp_path / "estimate.json")


def test_a_matrix_of_what_is_not_known_is_read(tmp_path):
    """Truth: what is not finite is written as null."""
    content = minimal()
    content["covariance"]["matrix"] = [[None]]
    (tmp_path / "estimate.json").write_text(json.dumps(content))
    assert read_estimate(tmp_path / "estimate.json") == content
