"""Values that are odd but writable: each is understood, or refused in one line with the exit code of its kind.

Truth: the contract of exit codes (docs/commands.md), and what the changed file says.
"""

import shutil

import numpy as np
import pytest

from mechid.ink.pens import Pens
from mechid.ink.sheet import Sheet


@pytest.fixture
def sampled(folder):
    """Return a function that gives a record of the folder another time column and header."""

    def change(header="time_s,torque_Nm", interval_s=1e-4):
        path = folder / "full_23.csv"
        torques = [line.split(",")[1] for line in path.read_text().splitlines()[1:]]
        rows = [f"{k * interval_s:.15g},{torque}" for k, torque in enumerate(torques)]
        path.write_text("\n".join([header, *rows]) + "\n")
        return folder

    return change


@pytest.mark.parametrize("interval_s", [pytest.param(20.0, marks=pytest.mark.slow), 1e-12])
def test_a_clock_that_is_very_slow_or_fast_is_checked(run, sampled, interval_s):
    """One sample in 20 s has no spectrum of a step, and a record of nanoseconds shows no rest."""
    result = run("check", sampled(interval_s=interval_s))
    assert result.exit_code == 0, result.stderr


@pytest.mark.parametrize(
    ("header", "word"),
    [
        ("time_s,torque_mNm_filtered", "mNm"),
        ("time_s,Torque in Ncm", "Ncm"),
        ("time_s,torque_MNm", "MNm"),
        ("time_s,torque_lbf_in", "lbf in"),
        ("time_msec,torque_Nm", "msec"),
        ("Zeit in ms,torque_Nm", "ms"),
    ],
)
def test_a_unit_within_a_name_is_asked_about(refused, sampled, header, word):
    """Truth: the header; read in N m or s the record would be off by the unit without a word."""
    line = refused(4, "check", sampled(header))
    assert f'"{word}" in its name may be its unit' in line


@pytest.mark.slow
def test_a_unit_that_the_campaign_file_gives_settles_it(run, sampled, changed):
    changed(
        "campaign.toml",
        'file = "full_23.csv"',
        'file = "full_23.csv"\nchannels = [ { quantity = "torque", column = "torque_mNm_raw", unit = "mN*m" } ]',
    )
    result = run("check", sampled("time_s,torque_mNm_raw"))
    assert result.exit_code == 0, result.stderr


def test_a_rate_of_next_to_nothing_is_checked(run, changed):
    result = run("check", changed("campaign.toml", "rate = 23.0", "rate = 1e-320"))
    assert result.exit_code == 0, result.stderr


@pytest.mark.parametrize("offset", ["-1e5", "1e300"])
def test_a_time_offset_that_no_clock_shows_is_refused(refused, changed, offset):
    """Before such a record a billion samples would have to be simulated, silently."""
    entry = f'file = "full_23.csv"\ntime_offset_s = {offset}'
    line = refused(3, "check", changed("campaign.toml", 'file = "full_23.csv"', entry))
    assert ".time_offset_s: found" in line


def test_a_link_that_leads_to_nothing_is_called_so(refused, tmp_path):
    (tmp_path / "bench").symlink_to(tmp_path / "gone")
    assert "it is a broken link" in refused(3, "check", tmp_path / "bench")


def test_a_record_or_an_output_that_is_a_link_to_nothing_is_called_so(refused, folder, tmp_path):
    (tmp_path / "out").symlink_to(tmp_path / "gone")
    for inside in ("", "within"):
        line = refused(2, "simulate", folder, "--out", tmp_path / "out" / inside)
        assert f"({tmp_path / 'out'} is a broken link)" in line
    (folder / "full_23.csv").unlink()
    (folder / "full_23.csv").symlink_to(tmp_path / "gone")
    assert "full_23.csv: there is no such file; it is a broken link" in refused(4, "check", folder)


@pytest.mark.parametrize("header", ["sample", "Index", "n", "sample_no", "Data Index", "No."])
def test_a_count_of_samples_is_not_the_time(refused, sampled, header):
    """Truth: what the header says; read in s the record would be an hour long, without a word."""
    line = refused(4, "check", sampled(f"{header},torque_Nm", interval_s=1.0))
    assert f'column "{header}": a count of samples by its name, not the time in seconds' in line


@pytest.mark.parametrize("header", ["sample_s", "index [ms]"])
def test_a_column_with_a_unit_of_time_is_the_time(run, sampled, header):
    result = run("check", sampled(f"{header},torque_Nm"))
    assert "by its name" not in result.stderr


def test_a_count_of_samples_is_not_the_torque(refused, sampled, changed):
    """With a sample rate the first column would be."""
    changed("campaign.toml", 'file = "full_23.csv"', 'file = "full_23.csv"\nsample_rate_hz = 1e4')
    line = refused(4, "check", sampled("sample,torque_Nm", interval_s=1.0))
    assert 'column "sample": a count of samples by its name, not the torque' in line


def test_a_start_angle_without_a_part_of_a_turn_is_refused(refused, changed):
    line = refused(3, "check", changed("campaign.toml", "start_angle_deg = 45.0", "start_angle_deg = 1e17"))
    assert "command.start_angle_deg: found 1e+17; write degrees, 1e+06 at most" in line


def test_a_command_that_makes_no_step_is_asked_about(run, changed):
    result = run("check", changed("campaign.toml", "rate = 23.0", "rate = 0.0"))
    assert 'record "full_23": its command makes no step until its last sample' in result.stdout


def test_more_detents_than_can_be_compiled_are_refused(refused, changed):
    """80 compile in two minutes, without a word until then."""
    detent = "[[stepper.detent]]\nperiod_deg = 1.8\namplitude = 0.01\nphase_deg = 0.0\n"
    line = refused(3, "check", changed("mechanism.toml", "[friction]", 63 * detent + "[friction]"))
    assert "stepper.detent: 65 tables, whose equations would take minutes to compile; keep 64 at most" in line


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ("--duration-s=nan", "duration: found nan"),
        ("--sample-rate-hz=inf", "sample rate: found inf"),
    ],
)
def test_a_time_base_that_is_none_is_refused_where_none_is_used_too(refused, folder, tmp_path, option, said):
    assert said in refused(2, "simulate", folder, "--out", tmp_path / "out", option)


@pytest.mark.parametrize("words", [["--out", ""], ["--out="]])
def test_an_empty_word_is_refused(refused, folder, words):
    """The folder in which mechid was started would be filled with results."""
    assert "--out: is empty, as of a shell variable without a value" in refused(2, "simulate", folder, *words)


def test_a_fit_whose_campaign_has_changed_is_handed_on_with_a_warning(run, fitted, tmp_path):
    campaign = shutil.copytree(fitted / "bench", tmp_path / "bench")
    asked = ["export", fitted / "fit", "--to", "tables", "--option", "rates=46"]
    asked += ["--campaign", campaign / "campaign.toml"]
    assert "changed since the fit" not in run(*asked, "--out", tmp_path / "one").stderr
    with (campaign / "mechanism.toml").open("a") as file:
        file.write("# changed\n")
    result = run(*asked, "--out", tmp_path / "other")
    assert result.exit_code == 0, result.stderr
    assert "warning: mechanism.toml: changed since the fit, whose values are handed on" in result.stderr


def test_without_a_supply_nothing_can_be_identified(refused, changed, tmp_path):
    changed("mechanism.toml", "peak_voltage = 5.7", "peak_voltage = 0.0")
    line = refused(3, "identify", changed("campaign.toml", "", ""), "--out", tmp_path / "out")
    assert "stepper.peak_voltage is 0, so the motor cannot move" in line


def test_a_prior_that_is_lost_in_rounding_is_refused(refused, changed):
    changed("mechanism.toml", "stiffness = { value = 2200.0,", "stiffness = { value = 2200.0, sigma = 1e-300,")
    assert "gear.stiffness.sigma: found 1e-300, which is lost in rounding beside 2200; write 2200 alone" in refused(
        3, "check", changed("campaign.toml", "", "")
    )


@pytest.mark.usefixtures("processes_that_draw")
def test_figures_are_drawn_whatever_a_notebook_has_set(tmp_path, monkeypatch):
    """Truth: the file is there; a notebook hands its own Matplotlib to what it starts."""
    monkeypatch.setenv("MPLBACKEND", "module://matplotlib_inline.backend_inline")
    two = np.array([1.0, 2.0])
    data = {"quantity": "torque", "hz": two, "amplitudes": (two,) * 3, "marks": [], "shown_hz": 2.0}
    with Pens() as pens:
        assert pens._processes
        pens.draw([Sheet("line", 2.4, "spectrum", data)], tmp_path)["line"].result()
    assert (tmp_path / "line.svg").is_file()
