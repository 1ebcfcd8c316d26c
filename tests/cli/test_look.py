"""`mechid look`. Truth: what the test has put into the records, and the contract of exit codes (docs/commands.md)."""

import json

import numpy as np
import pytest

from look_records import torque, written

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
