"""`mechid look`. Truth: what the test has put into the records, and the contract of exit codes (README)."""

import csv
import json
import re

import numpy as np
import pytest

from browser import chromium, faults, requests, shown
from mechid.reports.look.contents import FORMAT

RATE = 2000.0
TIME = np.arange(20_000) / RATE
NOISE = 0.003


def torque(seed=1, rate=41.0):
    """Return lines of a step rate, hum, and noise."""
    rng = np.random.default_rng(seed)
    y = sum(a * np.sin(2.0 * np.pi * o * rate * TIME) for o, a in ((0.5, 0.02), (1.0, 0.3), (2.0, 0.1), (3.0, 0.05)))
    return y + 0.02 * np.sin(2.0 * np.pi * 50.0 * TIME) + NOISE * rng.standard_normal(TIME.size)


def written(path, *columns, header="time_s,torque_Nm"):
    rows = "".join(",".join(f"{value:.7g}" for value in row) + "\n" for row in zip(TIME, *columns, strict=True))
    path.write_text(f"{header}\n{rows}")
    return path


@pytest.fixture(scope="module")
def looked(tmp_path_factory):
    """Return the folder of a look at a record of two channels and at one with gaps, and what was printed."""
    from typer.testing import CliRunner

    from mechid.cli.app import app

    folder = tmp_path_factory.mktemp("look")
    turns = np.round(41.0 * TIME + 0.1 * np.sin(2.0 * np.pi * 41.0 * TIME), 2)
    written(folder / "two.csv", torque(), turns, header="time_s,torque_Nm,ticks")
    gapped = torque(2)
    gapped[5_000:5_020] = np.nan
    written(folder / "gapped.csv", np.clip(gapped, -0.3, 0.3))
    result = CliRunner().invoke(
        app, ["look", str(folder / "two.csv"), str(folder / "gapped.csv"), "--out", str(folder / "out")]
    )
    assert result.exit_code == 0, result.output
    return folder / "out", result.stdout


def test_every_file_is_there_and_the_page_needs_nothing(looked):
    folder, stdout = looked
    assert {path.name for path in folder.iterdir()} == {"look.html", "look.json", "csv", "figures"}
    page = (folder / "look.html").read_text()
    assert not re.search(r'(?:src|href)="(?!#|data:)', page)
    assert "written: " in stdout
    assert (folder / "figures" / "gapped_spectrum.png").stat().st_size > 5000


def test_what_was_put_in_is_found_with_its_error(looked):
    data = json.loads((looked[0] / "look.json").read_text())
    assert data["format"] == FORMAT == "mechid-look/1"
    record = data["records"][0]
    assert record["driven"]["suggested"]["rates"][0] == pytest.approx(41.0, abs=0.01)
    channel = next(c for c in record["channels"] if c["quantity"] == "torque")
    lines = {line["order"]: line for line in channel["lines"] if line["order"]}
    for order, amplitude in ((0.5, 0.02), (1.0, 0.3), (2.0, 0.1), (3.0, 0.05)):
        assert lines[order]["amplitude"] == pytest.approx(amplitude, abs=5.0 * lines[order]["sigma"] + 1e-3 * amplitude)
    (hum,) = channel["mains"]
    assert (hum["mains_hz"], hum["order"]) == (50.0, None)
    assert hum["amplitude"] == pytest.approx(0.02, abs=5.0 * hum["sigma"])
    assert channel["noise"]["sigma"] == pytest.approx(NOISE, rel=0.05)


def test_gaps_and_clipping_are_counted(looked):
    (channel,) = json.loads((looked[0] / "look.json").read_text())["records"][1]["channels"]
    assert (channel["gaps"]["count"], channel["gaps"]["samples"]) == (1, 20)
    assert channel["gaps"]["first_at_s"] == [pytest.approx(2.5)]
    assert channel["clipped"]["count"] > 20


def test_third_octaves_and_what_is_below_make_up_the_rms(looked):
    """Parseval, within what the ends of a record's segments weigh less."""
    for record in json.loads((looked[0] / "look.json").read_text())["records"]:
        for channel in record["channels"]:
            if channel["quantity"] == "torque":
                total = sum(band["rms"] ** 2 for band in channel["third_octaves"]) + channel["below_rms"] ** 2
                assert np.sqrt(total) == pytest.approx(channel["rms"], rel=0.01)


def test_the_terminal_and_the_csv_say_the_same_numbers(looked):
    folder, stdout = looked
    data = json.loads((folder / "look.json").read_text())
    for record in data["records"]:
        for channel in record["channels"]:
            assert all(line in stdout for lines in channel["words"].values() for line in lines)
    lines = [line for record in data["records"] for channel in record["channels"] for line in channel["lines"]]
    rows = list(csv.DictReader((folder / "csv" / "lines.csv").read_text().splitlines()))
    assert [float(row["amplitude"]) for row in rows] == pytest.approx([line["amplitude"] for line in lines])
    density = np.loadtxt(folder / "csv" / "gapped_density.csv", delimiter=",", skiprows=1)
    assert density.shape[1] == 2


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", [1200, 390])
def test_the_page_in_a_browser_asks_for_nothing_and_complains_of_nothing(looked, width, dark):
    with chromium() as browser:
        shown(browser, looked[0] / "look.html", width, dark=dark)
        assert requests(browser) == [(looked[0] / "look.html").as_uri()]
        assert faults(browser) == []
        assert browser.execute_script("return document.documentElement.scrollWidth") <= width


CAMPAIGN = """
mechanism = "not_written_yet.toml"
[[record]]
name = "a"
file = "a.csv"
command = {{ stepping = "full", rate = {rate} }}
"""


@pytest.mark.parametrize(("rate", "says"), [(41.0, "as declared"), (44.0, "This contradicts the command")])
def test_a_campaign_gives_the_commands(run, tmp_path, rate, says):
    """Truth: the rate at which the record was made; the mechanism's file need not be there."""
    written(tmp_path / "a.csv", torque())
    (tmp_path / "campaign.toml").write_text(CAMPAIGN.format(rate=rate))
    result = run("look", tmp_path / "campaign.toml", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert says in result.stdout
    (record,) = json.loads((tmp_path / "out" / "look.json").read_text())["records"]
    assert f"{rate:g} full steps/s" in record["driven"]["declared"]["words"]
    if rate == 41.0:
        assert record["driven"]["reading"]["rate"] == pytest.approx(
            41.0, abs=4.0 * record["driven"]["reading"]["sigma"]
        )


BAD = {
    "unknown format": ("a.xyz", "1,2\n", 'no reader for ".xyz"'),
    "empty": ("a.csv", "", "a.csv"),
    "two samples": ("a.csv", "time_s,torque_Nm\n0,1\n0.1,2\n", "2 samples"),
    "nan everywhere": ("a.csv", "time_s,torque_Nm\n" + "".join(f"{k},nan\n" for k in range(40)), "no finite number"),
    "constant": ("a.csv", "time_s,torque_Nm\n" + "".join(f"{k},5\n" for k in range(40)), "the channel is dead"),
    "text": ("a.csv", "dear reader,\nthis is a letter\n", "a.csv"),
    "no mat file": ("a.mat", "nothing", "a.mat"),
}


@pytest.mark.parametrize("kind", BAD)
def test_what_is_no_record_is_4_and_leaves_nothing(refused, tmp_path, kind):
    name, content, says = BAD[kind]
    (tmp_path / name).write_text(content)
    assert says in refused(4, "look", tmp_path / name, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()


ODD = {
    "shortest": np.random.default_rng(1).standard_normal(16),
    "one sample": (np.arange(100) == 99).astype(float),
    "ramp": np.arange(2000.0),
    "two levels": np.random.default_rng(2).integers(0, 2, 3000).astype(float),
    "tiny": 1e-200 * np.random.default_rng(3).standard_normal(500),
    "far off zero": 1e9 + np.random.default_rng(4).standard_normal(3000),
}


@pytest.mark.parametrize("kind", ODD)
def test_odd_records_are_looked_at_too(run, tmp_path, kind):
    np.save(tmp_path / "a.npy", ODD[kind])
    result = run("look", tmp_path / "a.npy", "--sample-rate-hz", "1000", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert json.loads((tmp_path / "out" / "look.json").read_text())["records"]


def test_a_folder_and_a_missing_file_are_4(refused, tmp_path):
    assert "is a folder" in refused(4, "look", tmp_path, "--out", tmp_path / "out")
    assert "there is no such file" in refused(4, "look", tmp_path / "b.csv", "--out", tmp_path / "out")


def test_a_bad_file_among_good_ones_is_named_and_the_others_looked_at(refused, tmp_path):
    written(tmp_path / "good.csv", torque())
    (tmp_path / "bad.csv").write_text("time_s,torque_Nm\n0,1\n0.1,2\n")
    line = refused(4, "look", tmp_path / "good.csv", tmp_path / "bad.csv", "--out", tmp_path / "out")
    assert "1 of 2" in line
    data = json.loads((tmp_path / "out" / "look.json").read_text())
    assert [record["name"] for record in data["records"]] == ["good"]
    assert "2 samples" in data["left_out"][0]["message"]


def test_a_wrong_hint_says_what_is_wrong(refused, tmp_path):
    path = written(tmp_path / "a.csv", torque())
    out = ("--out", tmp_path / "out")
    assert "did you mean" in refused(4, "look", path, *out, "--column", "torqe")
    assert "torqe" in refused(2, "look", path, *out, "--quantity", "torqe")
    assert "does not measure" in refused(4, "look", path, *out, "--quantity", "force")
    assert "contradicts" in refused(4, "look", path, *out, "--sample-rate-hz", "100")


def test_a_folder_that_cannot_be_written_to_is_2(refused, tmp_path):
    path = written(tmp_path / "a.csv", torque())
    assert "is a file" in refused(2, "look", path, "--out", path / "out")
