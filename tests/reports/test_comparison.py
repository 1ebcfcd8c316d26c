"""Truth: fits written by hand; every number of the dict stands in what is printed."""

import json

import pytest

import mechid
from estimates import free, known, record, write
from mechid.errors import UsageError
from mechid.reports.comparison import comparison_data, print_comparison, write_comparison
from printing import printed, tables


@pytest.fixture
def data(tmp_path):
    """Return the comparison of a fit with two detents and one with one, which predicts worse."""
    shared = {"gear.stiffness": free(913.47, 0.022), "stepper.poles": known(100.0, "1")}
    amplitude = {"stepper.detent.1.amplitude": free(0.0231, 1.2e-5, "N m")}
    folders = [
        write(tmp_path / "two", {"full_46": record(0.002), "sweep": record(0.002, use="validate")}, shared | amplitude),
        write(tmp_path / "one", {"full_46": record(0.003), "sweep": record(0.004, use="validate")}, shared),
    ]
    return comparison_data(mechid.compare(*folders))


@pytest.mark.parametrize("width", [80, 120, 200])
def test_all_of_it_is_printed_within_the_width(data, width):
    text = printed(print_comparison, data, width)
    words = text.split()
    assert text.startswith(data["outcome"]["message"] + " Preferred: two.")
    for row in (*data["scores"], *data["records"], *data["parameters"]):
        assert all(word in words for cell in row["text"].values() for word in cell.split()), row["name"]
    assert max(len(line) for table in tables(text) for line in table) <= width


def test_criteria_are_shown_above_the_least(data):
    assert [row["text"]["aic_effective"] for row in data["scores"]] == ["0", "8107"]  # 1e4 ln 2.25 - 2


def test_what_a_hypothesis_lacks_is_a_dot(data):
    row = next(row for row in data["parameters"] if row["name"] == "stepper.detent.1.amplitude")
    assert (row["text"]["value_0"], row["text"]["value_1"], row["values"][1]) == ("0.023100", ".", None)


def test_the_file_reads_back(data, tmp_path):
    path = write_comparison(data, tmp_path / "deep" / "out")
    read = json.loads(path.read_text(), parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))
    assert (read["format"], read["preferred"]) == ("mechid-comparison/1", "two")
    assert read["scores"][1]["aic"] == data["scores"][1]["aic"]


def test_a_folder_that_cannot_be_made_is_refused(data, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="cannot be written to"):
        write_comparison(data, tmp_path / "file" / "out")
