"""`mechid simulate`; truth: an independent simulator's records, and the command line's own promises."""

import json

import numpy as np
import pytest

PROMISE = 1e-5
BESIDE = ("figures", "simulate.html", "simulate.md", "simulate.json")
"""What lies beside the samples."""


def read(path):
    return np.loadtxt(path, delimiter=",", skiprows=1)


def test_the_independent_records_are_reproduced(run, campaign_folder, tmp_path):
    """RMS error at most 1e-5 of each record's RMS (docs/numerics.md), on files that mechid did not make."""
    folder = campaign_folder / "exact"
    result = run("simulate", folder, "--out", tmp_path / "deep" / "sim")
    assert result.exit_code == 0, result.stderr
    files = sorted(folder.glob("*.csv"))
    assert [path.name for path in sorted((tmp_path / "deep" / "sim").glob("*.csv"))] == [path.name for path in files]
    for path in files:
        measured, simulated = read(path), read(tmp_path / "deep" / "sim" / path.name)
        assert np.array_equal(measured[:, 0], simulated[:, 0])
        error = np.linalg.norm(measured[:, 1] - simulated[:, 1]) / np.linalg.norm(measured[:, 1])
        assert error <= PROMISE, path.name


def test_the_file_has_one_header_line_and_ten_digits(run, folder, tmp_path):
    run("simulate", folder, "--out", tmp_path / "sim")
    header, *rows = (tmp_path / "sim" / "full_46.csv").read_text().splitlines()
    assert header == "time_s,torque_Nm"
    assert len(rows) == 10001
    assert min(len(row.split(",")[1].split("e")[0].lstrip("-").replace(".", "")) for row in rows) >= 10


@pytest.fixture
def planned(changed, folder):
    """Return the campaign with one record left, which has no file yet."""
    path = folder / "campaign.toml"
    head, _, _ = path.read_text().partition('\n[[record]]\nname = "full_46"')
    path.write_text(head.replace('file = "full_23.csv"\n', ""))
    return folder


def test_a_record_without_a_file_takes_rate_and_duration(run, planned, tmp_path):
    result = run("simulate", planned, "--out", tmp_path / "sim", "--sample-rate-hz", 5000, "--duration-s", 0.2)
    assert result.exit_code == 0, result.stderr
    time = read(tmp_path / "sim" / "full_23.csv")[:, 0]
    assert np.array_equal(time, np.arange(1001) / 5000.0)


def test_without_rate_and_duration_it_is_planned_as_for_the_design(run, planned, tmp_path):
    """Truth: docs/files.md, a constant rate lasts 1 s, and no other file says a rate."""
    result = run("simulate", planned, "--out", tmp_path / "sim")
    assert result.exit_code == 0, result.stderr
    assert np.array_equal(read(tmp_path / "sim" / "full_23.csv")[:, 0], np.arange(10_001) / 1e4)
    assert 'record "full_23" has no file: simulated for 1 s at 10000 Hz' in result.stderr


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--sample-rate-hz", "0", "--duration-s", "1"], "above 0"),
        (["--sample-rate-hz", "5000", "--duration-s", "-1"], "0 or more"),
        (["--sample-rate-hz", "nan", "--duration-s", "1"], "above 0"),
        (["--sample-rate-hz", "1e9", "--duration-s", "1e9"], "more than"),
    ],
)
def test_without_a_usable_time_base_it_is_2(refused, planned, tmp_path, options, says):
    assert says in refused(2, "simulate", planned, "--out", tmp_path / "sim", *options)


def test_a_record_with_a_file_keeps_its_time_base_and_this_is_said(run, folder, tmp_path):
    result = run("simulate", folder, "--out", tmp_path / "sim", "--sample-rate-hz", 5000)
    assert "whose time base is kept" in result.stderr
    assert len((tmp_path / "sim" / "full_46.csv").read_text().splitlines()) == 10002


def test_a_page_shows_what_was_simulated(run, folder, tmp_path):
    """Truth: the samples that lie beside it."""
    assert run("simulate", folder, "--out", tmp_path).exit_code == 0
    page = (tmp_path / "simulate.html").read_text(encoding="utf-8")
    data = json.loads((tmp_path / "simulate.json").read_text(encoding="utf-8"))
    for row in data["records"]:
        torque = read(tmp_path / f"{row['name']}.csv")[:, 1]
        assert row["samples"] == torque.size
        assert row["rms"] == pytest.approx(np.sqrt(np.mean(torque**2)), rel=1e-9)
        assert f'id="figure-simulated_{row["name"]}"' in page
        assert row["command"] in page
        assert (tmp_path / "figures" / f"simulated_{row['name']}.png").stat().st_size > 5000


def test_earlier_files_are_replaced_and_nothing_is_left_beside(run, folder, tmp_path):
    out = tmp_path / "sim"
    out.mkdir()
    (out / "full_46.csv").write_text("time_s,torque_Nm\n0,1.000000000000e+00\n")  # as an earlier run wrote it
    assert run("simulate", folder, "--out", out).exit_code == 0
    assert len((out / "full_46.csv").read_text().splitlines()) > 2
    assert {path.name for path in out.iterdir()} == {*(path.name for path in folder.glob("*.csv")), *BESIDE}
