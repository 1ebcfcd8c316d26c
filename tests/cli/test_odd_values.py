"""Values that are odd but writable: each is understood, or refused in one line with the exit code of its kind.

Truth: the contract of exit codes (README), and what the changed file says.
"""

import numpy as np
import pytest

from mechid.errors import UsageError
from mechid.interface.refits import bootstrap
from mechid.reports.pens import Pens
from mechid.reports.sheet import Sheet


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


@pytest.mark.parametrize("interval_s", [20.0, 1e-12])
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
        ("time_s,torque_lbf_in", "lbf"),
        ("time_msec,torque_Nm", "msec"),
        ("Zeit in ms,torque_Nm", "ms"),
    ],
)
def test_a_unit_within_a_name_is_asked_about(refused, sampled, header, word):
    """Truth: the header; read in N m or s the record would be off by the unit without a word."""
    line = refused(4, "check", sampled(header))
    assert f'"{word}" in its name may be its unit' in line


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
    assert "it is a link that leads to nothing" in refused(3, "check", tmp_path / "bench")


def test_without_a_supply_nothing_can_be_identified(refused, changed, tmp_path):
    changed("mechanism.toml", "peak_voltage = 5.7", "peak_voltage = 0.0")
    line = refused(3, "identify", changed("campaign.toml", "", ""), "--out", tmp_path / "out")
    assert "stepper.peak_voltage: found 0, with which nothing moves" in line


def test_a_prior_that_is_lost_in_rounding_is_refused(refused, changed):
    changed("mechanism.toml", "stiffness = { value = 2200.0,", "stiffness = { value = 2200.0, sigma = 1e-300,")
    assert "gear.stiffness.sigma: found 1e-300, which is lost in rounding beside 2200; write 2200 alone" in refused(
        3, "check", changed("campaign.toml", "", "")
    )


def test_more_draws_than_memory_holds_are_refused():
    """By the function that the command calls, so that scripts are refused too."""
    with pytest.raises(UsageError, match=r"99999999999 draws; 1000000 at most"):
        bootstrap(None, None, 99999999999)


def test_figures_are_drawn_whatever_a_notebook_has_set(tmp_path, monkeypatch):
    """Truth: the file is there; a notebook hands its own Matplotlib to what it starts."""
    monkeypatch.setenv("MPLBACKEND", "module://matplotlib_inline.backend_inline")
    two = np.array([1.0, 2.0])
    data = {"quantity": "torque", "hz": two, "amplitudes": (two,) * 3, "marks": [], "shown_hz": 2.0}
    with Pens() as pens:
        assert pens._processes
        pens.draw([Sheet("line", 2.4, "spectrum", data)], tmp_path)["line"].result()
    assert (tmp_path / "line.svg").is_file()
