"""A finished fit as a hypothesis. Truth: the files by hand."""

import pytest

import mechid
from estimates import BOTH, record, write
from mechid.errors import InputFileError, UsageError


@pytest.mark.parametrize(
    ("b", "message"),
    [
        ({"y": record(0.002)}, r'B: no record "x", which A has; compare fits of the same records'),
        ({"x": record(0.002, digest="cd" * 32)}, r'B: record "x": other samples \(sha256 cdcdcdcd, abababab in A\)'),
        ({"x": record(0.002, use="validate")}, r'B: record "x": use = "validate", "estimate" in A'),
    ],
)
def test_other_records_are_refused(pair, b, message):
    with pytest.raises(UsageError, match=message):
        pair({"x": record(0.002)}, b)


def test_a_fit_without_validation_is_refused(tmp_path):
    entry = record(0.002)
    del entry["validation"]
    folders = [write(tmp_path / name, {"x": r}, BOTH) for name, r in (("A", record(0.002)), ("B", entry))]
    with pytest.raises(InputFileError, match=r"estimate\.json: no 'validation'.*identify anew"):
        mechid.compare(*folders)


def test_folders_of_one_name_are_told_apart_by_their_parents(tmp_path):
    folders = [write(tmp_path / name / "fit", {"x": record(0.002)}, BOTH) for name in ("rigid", "housing")]
    assert [h.name for h in mechid.compare(*folders).hypotheses] == ["rigid/fit", "housing/fit"]
