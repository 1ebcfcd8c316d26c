"""Benches by other people's simulators; truth: mechid's own simulation of the same mechanism, which shares no line."""

import importlib.util
import json
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from foreign import by_heyoka, by_ngspice
from foreign.benches import NOISE_NM, RUNS, TRUTH_NAME, make_bench
from foreign.values import TRUTH
from mechid.campaign import catalogue_mechanism, load_campaign
from mechid.command import Command
from recovery import campaigns as recovery


def own(name, seconds):
    """Return mechid's simulation of a record's first seconds, with the bench's values."""
    command = Command.from_table(RUNS[name][0], "command", Path())
    return recovery.torque_of(catalogue_mechanism().with_values(TRUTH), recovery.Test(command, seconds))


def off(measured, modelled):
    """Return the RMS of a difference over the RMS of what is measured."""
    return np.sqrt(np.mean((modelled - measured) ** 2) / np.mean(measured**2))


def test_a_bench_has_the_catalogue_and_its_truth_and_keeps_what_is_there(tmp_path):
    made = []

    def make(command, seconds):
        made.append(command)
        return np.zeros(round(seconds * 1e3) + 1)

    make_bench(tmp_path, "nobody", "1.2", make, {"chopper_Hz": 5.0}, seed=0)
    told = json.loads((tmp_path / TRUTH_NAME).read_text())
    assert (told["synthetic"], told["simulator"], told["parameters"]) == (True, "nobody 1.2", dict(TRUTH))
    campaign = load_campaign(tmp_path)
    assert {p.name for p in campaign.mechanism.free} == set(TRUTH)
    noise = campaign.record("sweep").data.channel("torque").data
    assert np.std(noise) == pytest.approx(NOISE_NM, rel=0.05)
    (tmp_path / "sweep.csv").unlink()
    make_bench(tmp_path, "nobody", "1.2", make, {}, seed=0)
    assert len(made) == len(RUNS) + 1
    assert np.array_equal(load_campaign(tmp_path).record("sweep").data.channel("torque").data, noise)


@pytest.mark.skipif(importlib.util.find_spec("heyoka") is None, reason="heyoka is not installed")
@pytest.mark.parametrize("name", ["full_46", "micro_92"])
def test_heyoka_and_mechid_agree(name):
    assert off(by_heyoka.torque_of(sys.executable, RUNS[name][0], 0.2), own(name, 0.2)) < 1e-8


@pytest.mark.skipif(shutil.which("ngspice") is None, reason="ngspice is not installed")
def test_ngspice_with_its_chopper_is_near_to_mechid():
    """The chopper delays each step by up to 80 us, and friction is smooth: some per cent."""
    assert off(by_ngspice.torque_of(RUNS["full_46"][0], 0.04), own("full_46", 0.04)) < 0.05
