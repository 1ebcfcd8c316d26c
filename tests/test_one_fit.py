"""One fit in memory and in the folder it was left in: every function gives the same numbers, to the last digit."""

import numpy as np
import pytest
from scipy.signal import StateSpace

import mechid
from mechid.designs.design_file import CandidateChoice
from mechid.identification.result.estimate_file import json_text

FREE = ("gear.stiffness", "gear.damping")
TRUTH = {"gear.stiffness": 2000.0, "gear.damping": 0.45}
NOISE_NM, RATE_HZ, SECONDS = 0.002, 10_000.0, 0.2
COMMANDS = {
    "full_46": mechid.make_command("full", rate=46.0, start_angle_deg=45.0),
    "full_23": mechid.make_command("full", rate=23.0, start_angle_deg=45.0),
}
BODY = StateSpace([[0.0, 1.0], [-400.0, -0.4]], [[0.0], [0.1]], [[1.0, 0.0]], [[0.0]])
STRUCTURE = mechid.from_state_space(BODY, ("x",), has_interface=False)
BUDGET = {
    "mode": [{"name": "slew", "command": {"stepping": "full", "rate": 46.0}}],
    "requirement": [
        {
            "name": "jitter",
            "index": "APE",
            "axis": "x",
            "limit_rad": 1e-4,
            "interpretation": "temporal",
            "confidence": 0.95,
            "evaluation_period_s": 600.0,
        }
    ],
}
"""A body with one mode at 20 rad/s, driven by steady steps."""
OPTIONS = mechid.DesignOptions(
    mechanisms=2,
    candidates=CandidateChoice(steppings=("full",), rates=(40.0, 50.0), start_angles_deg=(0.0,), sweeps_s=()),
)


@pytest.fixture(scope="module")
def torques():
    """Return the noisy torque of each command at the truth, (n,) N m."""
    planned = [mechid.make_record(name, command=command) for name, command in COMMANDS.items()]
    made_by = mechid.catalogue_mechanism().with_values(TRUTH)
    bench, rng = mechid.make_campaign(made_by, planned), np.random.default_rng(7)
    runs = {name: mechid.simulate(bench, name, sample_rate_hz=RATE_HZ, duration_s=SECONDS) for name in COMMANDS}
    return {name: run.torque + NOISE_NM * rng.standard_normal(run.time.size) for name, run in runs.items()}


def identified(torques, place, free):
    """Return the fit of a campaign in files with some free parameters, and the folder in which it was left."""
    records = [
        mechid.make_record(name, torque, sample_rate_hz=RATE_HZ, command=COMMANDS[name])
        for name, torque in torques.items()
    ]
    start = mechid.catalogue_mechanism().with_values(TRUTH).with_free(free)
    mechid.write_campaign(mechid.make_campaign(start, records), place / "bench")
    folder = place / f"fit_{3 - len(free)}"
    return mechid.identify_into(mechid.load_campaign(place / "bench"), folder, workers=1).fit, folder


@pytest.fixture(scope="module")
def both(torques, tmp_path_factory):
    """Return a fit in memory, and its folder."""
    return identified(torques, tmp_path_factory.mktemp("one"), FREE)


@pytest.fixture(scope="module")
def others(torques, tmp_path_factory):
    """Return a second fit of the same records in memory, and its folder."""
    return identified(torques, tmp_path_factory.mktemp("other"), FREE[:1])


def profiled(fit, **_):
    return mechid.profile(fit, FREE[0], workers=1).to_dict()


def drawn(fit, **_):
    return mechid.bootstrap(fit, 3, workers=1).to_dict()


def diagnosed(fit, **_):
    return mechid.diagnose(fit, consider=["stepper.torque_harmonic"], workers=1).to_dict()


def designed(fit, campaign, **_):
    return mechid.design(campaign, OPTIONS, fit=fit, total_s=15.0, workers=1).to_dict()


def exported(fit, out, **_):
    made = mechid.export(fit, to="tables", out=out, options={"rates": "40,50"})
    return {name: (out / name).read_text() for name in made.written.files if name.endswith(".csv")}


def budgeted(fit, **_):
    found = mechid.budget(BUDGET, fit=fit, structure=STRUCTURE).to_dict()
    return {name: value for name, value in found.items() if name != "estimate"}  # where it was read from


def compared(fit, other, **_):
    return mechid.compare(fit, other).to_dict()


DESIGNED = pytest.param(designed, marks=pytest.mark.slow)


@pytest.mark.parametrize("function", [profiled, drawn, diagnosed, DESIGNED, exported, budgeted, compared])
def test_a_fit_in_memory_and_its_folder_are_one(both, others, tmp_path, function):
    in_memory, folder = both
    campaign = in_memory.campaign
    here = function(in_memory, campaign=campaign, out=tmp_path / "here", other=others[0])
    there = function(folder, campaign=campaign, out=tmp_path / "there", other=others[1])
    assert json_text(here) == json_text(there)
