"""`mechid check` on a bare data file, and what it says of conditioned records; truth: what the test wrote."""

import json

import numpy as np

from instrument_files import FORMATS, write_csv, write_tdms
from mechid.campaign import load_campaign
from mechid.checks.data_file import file_numbers
from mechid.checks.numbers import check_numbers


def test_a_files_columns_are_listed_with_unit_length_and_sampling(run, tmp_path):
    write_tdms(tmp_path / "run.tdms")
    result = run("check", tmp_path / "run.tdms")
    assert result.exit_code == 0
    lines = [" ".join(line.split()) for line in result.stdout.splitlines()]
    assert "index column unit samples rate Hz from s" in lines
    assert "0 run/Mz mN.m 64 1000 0" in lines
    assert "1 run/iA Amps 64 1000 0" in lines
    assert "says: serial = T-12" in lines


def test_every_format_is_listed(run, tmp_path):
    for one in FORMATS.values():
        one.write(tmp_path / one.name)
        rows = file_numbers(tmp_path / one.name)["columns"]
        torque = next(row for row in rows if row["column"].rpartition("/")[2].startswith("Mz"))
        assert (torque["samples"], torque["sample_rate_hz"], torque["start_s"]) == (64, 1000.0, 0.0)
        assert run("check", tmp_path / one.name).exit_code == 0


def test_a_column_that_is_no_channel_is_listed_with_the_reason(run, tmp_path):
    np.savez(tmp_path / "run.npz", a=np.ones(5) + 1j)
    assert "complex numbers; a record needs real ones" in run("check", tmp_path / "run.npz").stdout


def test_an_irregular_clock_is_a_warning(run, tmp_path):
    write_csv(tmp_path / "run.csv")
    text = (tmp_path / "run.csv").read_text().replace("0.010000", "0.010400")
    (tmp_path / "run.csv").write_text(text)
    result = run("check", tmp_path / "run.csv")
    assert result.exit_code == 0
    assert sum(line.startswith("warning: run.csv: line 12: irregular time") for line in result.stdout.splitlines()) == 1


def test_the_samples_of_a_text_without_a_clock_are_counted(run, tmp_path):
    (tmp_path / "run.txt").write_text("1 2\n" * 77)
    assert [" ".join(line.split()) for line in run("check", tmp_path / "run.txt").stdout.splitlines()][3:5] == [
        "0 77",
        "1 77",
    ]


def test_an_irregular_clock_has_its_median_rate(tmp_path):
    write_csv(tmp_path / "run.csv")
    text = (tmp_path / "run.csv").read_text().replace("0.010000", "0.010400")
    (tmp_path / "run.csv").write_text(text)
    row = file_numbers(tmp_path / "run.csv")["columns"][1]
    assert (row["text"]["sample_rate_hz"], row["clock"], row["text"]["start_s"]) == ("1000", "irregular", "")


def test_a_prose_text_is_4(refused, tmp_path):
    (tmp_path / "README.txt").write_text("What this is, in words\nSource: somewhere, and no numbers\n")
    assert "is not a number" in refused(4, "check", tmp_path / "README.txt")
    (tmp_path / "LICENSE.rst").write_text("words")
    assert 'no reader for ".rst"; mechid reads .csv' in refused(4, "check", tmp_path / "LICENSE.rst")


def test_a_damaged_file_is_4(refused, tmp_path):
    (tmp_path / "run.tdms").write_bytes(b"TDSm" + bytes(40))
    assert "run.tdms: " in refused(4, "check", tmp_path / "run.tdms")
    assert "there is no such file" in refused(4, "check", tmp_path / "absent.h5")


def test_a_campaigns_channels_are_a_table_with_statistics(run, folder):
    result = run("check", folder)
    assert "noise" in result.stdout
    data = check_numbers(load_campaign(folder))
    row = next(row for row in data["channels"] if row["table"] == "full_46")
    samples = np.loadtxt(folder / "full_46.csv", delimiter=",", skiprows=1)[:, 1]
    assert (row["min"], row["max"], row["samples"]) == (samples.min(), samples.max(), samples.size)
    np.testing.assert_allclose([row["mean"], row["rms"]], [samples.mean(), np.sqrt(np.mean(samples**2))], rtol=1e-9)
    json.dumps(data)


def test_what_was_conditioned_is_said(run, changed):
    folder = changed(
        "campaign.toml", 'name = "full_46"', 'name = "full_46"\nconditioning = { window_s = [0.0, 0.5], decimate = 2 }'
    )
    result = run("check", folder)
    assert "conditioned: 0 s to 0.5 s of the record used" in result.stdout
    assert "conditioned: decimated by 2 from 10000 Hz to 5000 Hz" in result.stdout
