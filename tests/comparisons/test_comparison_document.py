"""Truth: fits written by hand; every number of the dict stands in what is printed."""

import json

import numpy as np
import pytest

import mechid
from estimates import free, known, record, write
from mechid.comparisons.document import PRESENTER
from mechid.comparisons.figures import (
    EVIDENCE_NAME,
    RECORDS_NAME,
    SPECTRA_NAME,
    comparison_figures,
    criterion_differences,
    most_different_spectra,
    residual_ratios,
)
from mechid.errors import UsageError
from mechid.ink.in_markdown import document_markdown
from printing import printed, tables


@pytest.fixture
def found(tmp_path):
    """Return the comparison of a fit with two detents and one with one, which predicts worse."""
    shared = {"gear.stiffness": free(913.47, 0.022), "stepper.poles": known(100.0, "1")}
    amplitude = {"stepper.detent.1.amplitude": free(0.0231, 1.2e-5, "N m")}
    folders = [
        write(tmp_path / "two", {"full_46": record(0.002), "sweep": record(0.002, use="validate")}, shared | amplitude),
        write(tmp_path / "one", {"full_46": record(0.003), "sweep": record(0.004, use="validate")}, shared),
    ]
    return mechid.compare(*folders)


@pytest.fixture
def data(found):
    return PRESENTER.numbers(found)


@pytest.mark.parametrize("width", [80, 120, 200])
def test_all_of_it_is_printed_within_the_width(data, width):
    text = printed(PRESENTER.print, data, width)
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


def test_the_file_reads_back(found, data, tmp_path):
    out = tmp_path / "deep" / "out"
    names = {path.name for path in PRESENTER.write(found, data, out)}
    assert names == {"comparison.json", "comparison.md", "comparison.html", "figures"}
    read = json.loads((out / "comparison.json").read_text(), parse_constant=lambda n: pytest.fail(f"{n} is no JSON"))
    assert (read["format"], read["preferred"]) == ("mechid-comparison/1", "two")
    assert read["scores"][1]["aic"] == data["scores"][1]["aic"]
    assert {path.stem for path in (out / "figures").iterdir()} == {EVIDENCE_NAME, RECORDS_NAME}


def test_page_and_markdown_say_what_the_terminal_does(found, data, tmp_path):
    """Truth: the message, the ratios of the residuals by hand, the difference of the criteria."""
    PRESENTER.write(found, data, tmp_path)
    for name in ("comparison.html", "comparison.md"):
        text = (tmp_path / name).read_text()
        assert data["outcome"]["message"] + " Preferred: two." in text
        assert "8107" in text
    assert residual_ratios(data) == pytest.approx(np.array([[1.0, 1.5], [1.0, 2.0]]))
    rows = [row["bic_effective"] for row in data["scores"]]
    assert criterion_differences(data, "bic_effective") == pytest.approx([0.0, rows[1] - rows[0]])


def test_a_folder_that_cannot_be_made_is_refused(found, data, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="cannot be written to"):
        PRESENTER.write(found, data, tmp_path / "file" / "out")


def test_residual_spectra_stand_side_by_side(data):
    """Truth: fits written by hand leave no residual.json, so that there is nothing to draw."""
    assert data["spectra"]["records"] == []
    text = document_markdown(PRESENTER.document(data))
    assert "Residual spectra" not in text
    rms = [[1e-3] * 41, None]
    record = {"name": "sweep", "rms": rms, "noise": [1e-4] * 41}
    shown = {**data, "spectra": {**data["spectra"], "records": [record]}}
    assert f"figures/{SPECTRA_NAME}" in document_markdown(PRESENTER.document(shown))
    assert SPECTRA_NAME in dict(comparison_figures(shown))
    more = [{**record, "name": name} for name in ("full_46", "sweep")]
    assert [one["name"] for one in most_different_spectra({**shown, "spectra": {"records": more}})] == [
        "full_46",
        "sweep",
    ]
