"""Test report of an emission verdict. Truth: emission.json, and the campaign file that declares the test."""

import hashlib
import json
from dataclasses import replace
from itertools import islice

import pytest

import mechid
import word_files
from emission_bench import background, record, requirement, samples, write_campaign
from mechid.emissions.document import PRESENTER
from mechid.emissions.figures import emission_figures
from mechid.errors import UsageError

DECLARED = """
[article]
name = "SADM-200"
[test]
date = 2026-04-02
deviations = ["No run at 90 steps/s."]
[[instrument]]
name = "9255C"
calibration_due = 2026-03-01
"""


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    """Return the folder of a verdict with a pass, a fail and a mask beyond the band."""
    folder = tmp_path_factory.mktemp("emission")
    wanted = [
        requirement("quiet"),
        requirement("loud", mask=((20.0, 0.01), (500.0, 0.01))),
        requirement("far", "mz", unit="N*m", mask=((20.0, 0.1), (900.0, 0.1))),
    ]
    runs = {"run": samples(1, ((46.0, 0.05),)), "fast": samples(3, ((60.0, 0.05),)), "off": samples(2)}
    write_campaign(folder, runs, record("run", 46.0), record("fast", 60.0), background(), DECLARED, *wanted)
    found = mechid.emission(folder)
    # All figures would take three seconds.
    few = replace(PRESENTER, figures=lambda *of: islice(emission_figures(*of), 2))
    few.write(found, few.numbers(found), folder / "out", docx=True)
    return folder / "out"


@pytest.fixture(scope="module")
def data(out):
    return json.loads((out / "emission.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def file(out):
    return word_files.opened(out / "emission.docx")


def test_the_verification_table_is_that_of_the_numbers(file, data):
    header, *rows = word_files.table_under(file, "Verification")
    assert header == ["requirement", "method", "value", "limit", "margin", "verdict", "evidence"]
    assert len(rows) == len(data["requirements"]) == 3
    digests = {one["name"]: one["sha256"] for one in data["sources"]}
    for row, one in zip(rows, data["requirements"], strict=True):
        worst, text = one["worst"], one["text"]
        assert row[0].startswith(f"{one['name']} ({one['direction']}, ")
        assert row[1] == "test"
        assert (
            row[2]
            == f"{text['value']} {one['unit'].replace('*', ' ')} at {text['frequency']} Hz, {text['rate']} steps/s"
        )
        assert row[4] == f"{worst['margin_dB']:+.1f} dB"
        assert row[5] == text["verdict"]
        assert f"record {worst['record']}: {worst['record']}.npy, sha256 {digests[worst['record']][:16]}" in row[6]
    assert [row[5] for row in rows] == ["pass", "fail", "pass"]


def test_records_and_results_are_listed_with_their_digests(file, data, out):
    """Truth: the bytes of the files."""
    read = {row[0]: row[2] for row in word_files.table_under(file, "Files that were read")[1:]}
    campaign = out.parent
    assert set(read) == {"run.npy", "fast.npy", "off.npy", "campaign.toml"}
    left = {row[0]: row[2] for row in word_files.table_under(file, "Files of the result beside this one")[1:]}
    assert set(left) == {"emission.json", "lines.csv", "verdicts.csv"}
    for folder, files in ((campaign, read), (out, left)):
        assert files == {name: hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in files}
    assert data["provenance"]["inputs_sha256"] == {"campaign.toml": read["campaign.toml"]}


def test_the_background_is_given_by_its_level(file, data):
    """Truth: white noise of 0.01 N over 1000 Hz, of which 781.25 less 3 Hz are judged."""
    rows = word_files.table_under(file, "Level of the background")[1:]
    assert [row[:2] for row in rows] == [[one["direction"], "off"] for one in data["backgrounds"]]
    expected = 0.01 * ((2000.0 / 2.56 - 3.0) / 1000.0) ** 0.5
    assert [float(row[2]) for row in rows] == pytest.approx([expected] * len(rows), rel=0.03)


def test_what_was_declared_and_what_deviates_is_said(file):
    text = word_files.text_of(file)
    assert "9255C: its calibration was due on 2026-03-01, before the test of 2026-04-02." in text
    assert "No run at 90 steps/s." in text
    assert "loud: fail." in text
    assert "far: its mask from 20 to 900 Hz is judged from 20 to 781.25 Hz alone." in text
    assert text.count("Not declared in campaign.toml.") == 2  # set-up and conditions
    assert "2 runs at 46 to 60 full steps/s, sampled at 2000 Hz." in text


def test_every_figure_is_a_picture_with_a_caption(file):
    captions = [text for text in word_files.captions(file) if text.startswith("Figure")]
    assert captions == ["Figure 1: Amplitude spectra of fx with masks", "Figure 2: Waterfall of fx over the step rate"]
    assert len(file.inline_shapes) == 2


@pytest.mark.slow
def test_libreoffice_prints_every_section_and_requirement(out, data, tmp_path):
    """Truth: the headings and the requirements; the pages are those that LibreOffice makes."""
    pages = word_files.printed(out / "emission.docx", tmp_path)
    for level, heading in word_files.headings(word_files.opened(out / "emission.docx")):
        assert level > 2 or heading in pages
    for one in data["requirements"]:
        assert one["name"] in pages
    for digest in (one["sha256"] for one in data["sources"]):
        assert digest in pages


def test_a_result_without_a_test_report_refuses(tmp_path):
    record_a = mechid.make_record("a", command=mechid.make_command("full", rate=46.0))
    run = mechid.simulate(mechid.make_campaign(mechid.catalogue_mechanism(), [record_a]), duration_s=0.01)
    with pytest.raises(UsageError, match="docx: no test report is made of a Trajectory"):
        run.write(tmp_path / "out", docx=True)
    assert not (tmp_path / "out").exists()
