"""What a design says of rival explanations, held against records of an independent simulator. SYNTHETIC."""

import logging
import tomllib
from dataclasses import replace

import numpy as np
import pytest

from incomplete.benches import make_bench, true_record
from mechid.campaign import load_campaign
from mechid.campaign.campaign_writer import command_text
from mechid.command import Command, RateProfile
from mechid.designs.alternatives import Group, refit_from_best
from mechid.designs.candidates import CandidateChoice
from mechid.designs.design import make_design
from mechid.designs.design_file import DesignOptions, Limits
from mechid.designs.document import PRESENTER
from mechid.designs.group_separation import separation
from mechid.designs.numbers import design_numbers
from mechid.designs.planned_record import PlannedRecord
from mechid.designs.separation import CLEAR, refit
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.diagnosis.candidate import CandidateModel, Setting
from mechid.identification.identify import make_problem

LOG = logging.getLogger(__name__)
KNOWN = ("micro_res", "full_slow")
RATES = (10.0, 30.0, 60.0)
NOISES = (5, 6, 7, 8)


@pytest.fixture(autouse=True)
def _one_core():
    with one_core_algebra():
        yield


def rivals_of_bench(effect, seed, names, folder):
    """Return a campaign of two records of a bench, and two rivals fitted to them."""
    make_bench(effect, seed, folder)
    campaign = load_campaign(folder)
    campaign = replace(campaign, records=tuple(r for r in campaign.records if r.name in KNOWN))
    problem = make_problem(campaign, 1)
    plain = CandidateModel(Setting(problem, problem.whole_windows(), (), frozenset(names)), campaign.mechanism).at({})
    less = plain.fit(plain)
    return campaign, Group(names, refit_from_best([less.with_effect(name) for name in names]))


def planned(rate):
    command = Command(stepping="full", microsteps=1, rate=RateProfile.constant(rate), start_angle_deg=45.0)
    return PlannedRecord(name=f"full_{rate:g}", command=command, duration_s=1.0)


def designed(campaign, group):
    """Return what is proposed of full steps at three rates."""
    pool = [planned(rate) for rate in RATES]
    all_of_them = np.ones(len(pool), dtype=bool)
    found = separation(
        campaign, [group], pool, driven=all_of_them, allowed=all_of_them, seconds=np.full(len(pool), 11.0), total_s=30.0
    )
    return pool, found


def falls_with(campaign, group, record, effect, seed):
    """Return by how much the second rival loses with a true record as well: without noise, and in four draws."""
    command = tomllib.loads(f"command = {command_text(record.command)}")["command"]
    torque = true_record(effect, seed, command, record.duration_s).torque_Nm
    noises = [np.random.default_rng(n).standard_normal(torque.size) for n in NOISES]
    falls = []
    for noise in (0.0, *noises):
        measured = torque + record.sigma * noise
        true, other = (refit(campaign, model, [record], [measured])[0] for model in group.models)
        falls.append(other - true)
    return falls


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "names"),
    [
        ("kinematic_error", ("gear.kinematic_error:4", "gear.kinematic_error:3")),
        ("torque_harmonic", ("stepper.torque_harmonic:3", "stepper.microstep_table")),
    ],
)
def test_the_wrong_rival_loses_by_what_the_design_says(effect, names, tmp_path):
    """Truth: the first rival, in a record that the independent simulator made of it.

    Both are known from two records of 1 s. The record proposed is taken and both are fitted to all three. The
    chi-square promised, c, scatters by 2 sqrt(c) with the noise and with what the old records leave open of the truth:
    the mean of four draws of noise is within three times that, and every one is enough for a diagnosis.
    """
    campaign, group = rivals_of_bench(effect, 3, names, tmp_path)
    pool, found = designed(campaign, group)
    (one,) = found.groups
    assert one.is_clear
    (chosen,) = found.chosen
    promise = next(p for p, pair in zip(one.promises, one.pairs, strict=True) if pair.true == names[0])
    assert promise.by_refit >= CLEAR
    without_noise, *falls = falls_with(campaign, group, pool[chosen], effect, 3)
    LOG.info(
        "%s %s now %s %s without noise %s with %s",
        effect,
        pool[chosen].name,
        one.pairs[0].now,
        promise,
        without_noise,
        falls,
    )
    assert min(falls) >= 30.0
    assert np.mean(falls) == pytest.approx(promise.by_refit, abs=6.0 * np.sqrt(promise.by_refit))
    assert without_noise == pytest.approx(promise.by_refit, abs=6.0 * np.sqrt(promise.by_refit))


@pytest.mark.slow
def test_a_constant_voltage_and_a_detent_of_an_electrical_period_make_the_same_torque(tmp_path):
    """Truth: a constant voltage u drives a constant current u/R, whose torque turns once in an electrical period.

    The design proposes nothing, and a true record of the fastest steps does not tell them apart either.
    """
    names = ("stepper.detent:7.2deg", "stepper.phase_offset")
    campaign, group = rivals_of_bench("phase_offset", 21, names, tmp_path)
    pool, found = designed(campaign, group)
    (one,) = found.groups
    assert found.chosen == ()
    assert one.reach < 0.1
    falls = falls_with(campaign, group, pool[-1], "phase_offset", 21)
    LOG.info("at most %s to first order; with a true record %s", one.reach, falls)
    assert np.max(np.abs(falls)) < 0.1


@pytest.mark.slow
def test_the_record_that_tells_is_proposed_first_and_says_why(tmp_path):
    """Truth: laws between what is chosen, what is written and what is said of it."""
    names = ("gear.kinematic_error:4", "gear.kinematic_error:3")
    campaign, group = rivals_of_bench("kinematic_error", 3, names, tmp_path / "bench")
    choices = CandidateChoice(steppings=("full",), rates=(10.0, 60.0), start_angles_deg=(45.0,), sweeps_s=())
    options = DesignOptions(candidates=choices, limits=Limits(total_s=22.0), mechanisms=1)
    design = make_design(campaign, options, rivals=[group])
    PRESENTER.write(design, data := design_numbers(design), tmp_path / "out")
    (entry,) = data["rivals"]
    assert entry["clear"]
    assert set(entry["records"]) <= {r["name"] for r in data["chosen"]["records"]}
    (record,) = entry["records"]
    alone = {c["name"]: c["tells_apart"][names[0]] for c in data["candidates"] if not c["objection"]}
    assert alone[record] == max(alone.values())
    assert alone[record] == pytest.approx(min(pair["first_order"] for pair in entry["pairs"]))
    (line,) = [x for x in (tmp_path / "out" / "campaign.toml").read_text().splitlines() if "is to tell" in x]
    assert f"is to tell {names[0]} from {names[1]}" in line
    assert f"drive {record} (11 s" in (tmp_path / "out" / "design.md").read_text().replace("\\_", "_")
