"""The files of a report. Truth: the dict they are made of, and the rules for a page that stands alone."""

import base64
import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from mechid.errors import InputFileError
from mechid.ink import on_page
from mechid.reports.curves import record_curves
from mechid.reports.figure_cache import page_script
from mechid.reports.results import read_truth
from mechid.reports.sections import report_document

SVG = "{http://www.w3.org/2000/svg}"
FIGURES = {
    "full_46_torque": {"time, s", "torque, N m", "residual, N m"},
    "full_46_spectrum": {"frequency, Hz", "amplitude, N m"},
    "full_46_residual": {"frequency, Hz", "residual density, N m/√Hz", "lag, samples", "autocorrelation"},
    "sweep_torque": {"time, s", "torque, N m", "residual, N m"},
    "sweep_spectrum": {"frequency, Hz", "amplitude, N m"},
    "sweep_residual": {"frequency, Hz", "residual density, N m/√Hz"},
    "sweep_spectrogram": {"time, s", "frequency, Hz", "amplitude, N m"},
    "correlation": {"correlation", "gear.stiffness", "gear.damping"},
    "information": {"share of the information, %", "full_46"},
}


@pytest.fixture
def page(reported):
    return (reported.folder / "report.html").read_text(encoding="utf-8")


@pytest.fixture
def data(reported):
    return json.loads((reported.folder / "report.json").read_text(encoding="utf-8"))


def page_of(data, curves, pictures):
    script = page_script(curves, data["resonances"])
    return "".join(on_page.interactive_page(report_document(data, curves), pictures, script))


def test_the_files_are_there_and_nothing_beside(reported):
    names = ["figures", "report.html", "report.json", "report.md"]
    assert sorted(path.name for path in reported.files) == sorted(p.name for p in reported.folder.iterdir()) == names
    files = {path.name for path in (reported.folder / "figures").iterdir()}
    assert files == {f"{name}.{suffix}" for name in FIGURES for suffix in ("svg", "png")}


def test_the_page_asks_for_nothing_from_outside(page):
    without_namespaces = re.sub(r'<script type="(text/plain|application/json)".*?</script>', "", page, flags=re.DOTALL)
    assert re.findall(r'(?:src|href)="(?!data:|#)[^"]*"', without_namespaces) == []
    assert "http" not in re.sub(r"http-equiv|base64,[^\"]*", "", without_namespaces)
    assert "default-src 'none'" in page


@pytest.mark.parametrize("most", [len(FIGURES) - 1, len(FIGURES)])
def test_the_page_of_many_records_names_the_files_of_its_figures(reported, data, most, monkeypatch):
    """Truth: the files in the folder; each stands on the page once, as a picture or by name."""
    monkeypatch.setattr(on_page, "MOST_PICTURES", most)
    shown = reported.validation.values()
    curves = [one for record in shown for one in record_curves(reported.campaign, reported.fit, record)]
    files = {name: reported.folder / "figures" / f"{name}.svg" for name in FIGURES}
    text = page_of(data, curves, files)
    pictures = [base64.b64decode(one).decode() for one in re.findall(r'src="data:image/svg\+xml;base64,([^"]*)"', text)]
    shown_there = FIGURES.keys() - {"correlation", "information"}  # which are tables there
    if most < len(FIGURES):
        assert set(re.findall(r'href="figures/(.*?)\.svg"', text)) == shown_there
        assert not pictures
    else:
        assert sorted(pictures) == sorted(files[name].read_text() for name in shown_there)
        assert 'href="figures/' not in text


def test_the_names_of_many_records_are_folded(reported, data):
    """Truth: 41 sets of curves; the verdict would else begin below the first screen."""
    (curves,) = record_curves(reported.campaign, reported.fit, reported.validation["full_46"])
    for count in (40, 41):
        text = page_of(data, [curves] * count, {})
        contents = text[text.index("<nav") : text.index("</nav>")]
        assert contents.count('<a href="#record-full_46">') == count
        assert (f"<summary>{count} records</summary>" in contents) == (count > 40)


def test_hostile_names_are_text_in_page_and_tables(page, reported):
    assert "<img src=x" not in page
    assert "&lt;img src=x" in page
    assert re.search(r"(?<!\\)<img", (reported.folder / "report.md").read_text()) is None


@pytest.mark.parametrize("name", FIGURES)
def test_figures_have_labels_with_units_as_text(reported, name):
    root = ElementTree.parse(reported.folder / "figures" / f"{name}.svg").getroot()
    texts = {"".join(element.itertext()).strip() for element in root.iter(f"{SVG}text")}
    assert FIGURES[name] <= texts
    with Image.open(reported.folder / "figures" / f"{name}.png") as image:
        assert image.width == 1380  # 6.9 in, both columns of a paper, at 200 dots an inch


def test_the_tables_hold_the_dicts_texts(reported, data):
    text = (reported.folder / "report.md").read_text(encoding="utf-8").replace("\\", "")
    for row in data["parameters"]:
        assert row["name"] in text
        assert row["text"]["estimate"] in text
        assert row["text"]["std_error"] in text
    assert all(digest in text for digest in data["provenance"]["inputs_sha256"].values())
    assert data["summary"]["headline"] in text
    rows = [line for line in text.splitlines() if line.startswith("|")]
    assert all(line.endswith("|") for line in rows)


def test_correlation_and_information_are_the_fits(reported, data):
    assert np.array(data["correlation"]["matrix"]) == pytest.approx(reported.fit.correlation)
    assert data["information"]["records"] == ["full_46"]
    assert np.array(data["information"]["share_percent"]) == pytest.approx(100.0)
    assert data["summary"]["tone"] in ("good", "caution")


def test_the_truth_of_an_earlier_report_is_read(reported, tmp_path):
    assert read_truth(reported.folder) == (True, {})
    with pytest.raises(InputFileError, match="no such file"):
        read_truth(tmp_path)
    (tmp_path / "report.json").write_text("{")
    with pytest.raises(InputFileError, match="is damaged"):
        read_truth(tmp_path)
