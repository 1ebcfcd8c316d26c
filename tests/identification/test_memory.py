"""Memory of an identification: what the demo takes, and what a longer record adds."""

import subprocess
import sys

import numpy as np
import pytest

from mechid.campaign import mechanism_text
from mechid.campaign.bench import write_bench
from mechid.campaign.trajectory_file import record_rows
from mechid.command import Command, RateProfile
from mechid.writing import write_atomically
from synthetic import NOISE_NM, RATE_HZ, displaced, torque_of, truth

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads the peak from /proc"),
]

BYTES_A_SAMPLE = 8
"""Of its step edges, which are in memory, and of what a process takes for reading by blocks."""
DEMO_BYTES = 450e6
IDENTIFY = """
import sys
from pathlib import Path
from mechid.campaign import load_campaign
from mechid.cli.identification import identify_into

identify_into(load_campaign(sys.argv[1]), Path(sys.argv[2]), workers=2)
status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
print("peak", int(status["VmHWM"].split()[0]) * 1024)
"""
"""The peak is that of the process's own pages; getrusage would start from the peak of the process that forked it."""


def peak_bytes(folder):
    """Identify a campaign in a process of its own, and return its peak memory."""
    command = [sys.executable, "-c", IDENTIFY, str(folder), str(folder / "result")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    return int(done.stdout.split()[-1])


def sweep_over(seconds):
    """Return the command of the microstep sweep from 0 to 120 steps/s, and a noisy record of it with its time."""
    profile = RateProfile.through([(0.0, 0.0), (seconds, 120.0)])
    command = Command(stepping="micro", microsteps=16, rate=profile)
    samples = round(seconds * RATE_HZ) + 1
    noise = NOISE_NM * np.random.default_rng(41).standard_normal(samples)
    return np.arange(samples) / RATE_HZ, torque_of(truth(), command, samples) + noise


@pytest.fixture
def bench_of(tmp_path):
    """Return a function that writes the bench with a sweep of so many seconds, two parameters free off the truth."""

    def make(seconds):
        folder = tmp_path / f"{seconds:.0f}"
        write_bench(folder, seed=1, sweep_s=1.0)
        start = displaced(truth(), {"gear.stiffness": 1.1, "gear.damping": 0.8})
        write_atomically(folder / "mechanism.toml", mechanism_text(start, "two parameters free"))
        campaign = folder / "campaign.toml"
        text = campaign.read_text()
        assert "[1.0, 2.0]" in text
        campaign.write_text(text.replace("[1.0, 2.0]", f"[{seconds:.1f}, 120.0]"))
        time, torque = sweep_over(seconds)
        rows = record_rows(time, torque, time_format="%.6f", torque_format="%.9e")
        write_atomically(folder / "sweep.csv", rows)
        return folder

    return make


def test_a_longer_record_adds_no_more_than_its_step_edges(bench_of):
    """Truth: the promise, 8 bytes a sample; the sweep of 600 s against that of 60 s, kernels compiled before."""
    peak_bytes(bench_of(6.0))
    short, long = (peak_bytes(bench_of(seconds)) for seconds in (60.0, 600.0))
    added = (long - short) / (540.0 * RATE_HZ)
    assert short > 200e6, "the process itself takes more"
    assert added <= BYTES_A_SAMPLE, f"{added:.1f} bytes a sample, from {short / 1e6:.0f} to {long / 1e6:.0f} MB"


def test_the_demo_stays_below_450_megabytes(tmp_path):
    """Truth: the promise; the demo's campaign, all 15 parameters from the catalogue, kernels compiled before."""
    write_bench(tmp_path / "first", seed=0, sweep_s=1.0)
    peak_bytes(tmp_path / "first")
    write_bench(tmp_path / "demo", seed=0)
    peak = peak_bytes(tmp_path / "demo")
    assert peak <= DEMO_BYTES, f"{peak / 1e6:.0f} MB"
