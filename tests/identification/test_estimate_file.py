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
        ("[]", "format: found null"),
        ("{", "cannot be read"),
    ],
)
def test_a_file_that_is_no_estimate_is_refused(tmp_path, content, fragment):
    path = tmp_path / "estimate.json"
    path.write_text(content)
    with pytest.raises(InputFileError, match=r"estimate\.json") as error:
        read_estimate(path)
    assert fragment in str(error.value)


def test_a_missing_file_is_refused_with_a_remedy(tmp_path):
    with pytest.raises(InputFileError, match="mechid identify"):
        read_estimate(tmp_path / "estimate.json")
