"""What a design says of rival explanations, held against records of an independent simulator. SYNTHETIC."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest

from incomplete.benches import make_bench, true_record
from mechid.campaign import load_campaign
from mechid.command import Command, RateProfile
from mechid.design.planned import PlannedRecord
from mechid.design.proposal import command_text
from mechid.design.rivals import Group, fitted_alike
from mechid.design.separating import separation
from mechid.design.separation import CLEAR, refitted
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.diagnosis.candidate import Model, Setting
from mechid.identification.identify import make_problem

KNOWN = ("micro_res", "full_slow")
RATES = (10.0, 30.0, 60.0)


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
    plain = Model(Setting(problem, problem.whole(), ()), campaign.mechanism).at({})
    less = plain.fitted(plain)
    return campaign, Group(names, fitted_alike([less.with_effect(name) for name in names]))


def planned(rate):
    command = Command(stepping="full", microsteps=1, rate=RateProfile.constant(rate), start_angle_deg=45.0)
    return PlannedRecord(name=f"full_{rate:g}", command=command, duration_s=1.0)


def designed(campaign, group):
    """Return what is proposed of full steps at three rates."""
    pool = [planned(rate) for rate in RATES]
    all_of_them = np.ones(len(pool), dtype=bool)
    found = separation(campaign, [group], pool, driven=all_of_them, allowed=all_of_them,
                       seconds=np.full(len(pool), 11.0), total_s=30.0)  # fmt: skip
    return pool, found


def costs_with(campaign, group, record, effect, seed):
    """Return the cost of each rival fitted to all records, a true and noisy one among them."""
    command = tomllib.loads(f"command = {command_text(record.command)}")["command"]
    torque = true_record(effect, seed, command, record.duration_s).torque_Nm
    torque = torque + record.sigma * np.random.default_rng(5).standard_normal(torque.size)
    return [refitted(campaign, model, [record], [torque])[0] for model in group.models]


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

    Both are known from two records of 1 s. The record proposed is taken, both are fitted to all three, and the chi-square
    by which the other loses is the one promised within three standard deviations of its noise, 2 sqrt(chi-square) each.
    """
    campaign, group = rivals_of_bench(effect, 3, names, tmp_path)
    pool, found = designed(campaign, group)
    (one,) = found.groups
    assert one.clear
    assert one.expected >= CLEAR
    (chosen,) = found.chosen
    promise = next(p for p, pair in zip(one.promises, one.pairs, strict=True) if pair.true == names[0])
    true, other = costs_with(campaign, group, pool[chosen], effect, 3)
    print(effect, pool[chosen].name, one.pairs[0].now, promise, other - true)
    assert other - true >= 30.0
    assert other - true == pytest.approx(promise.refitted, abs=6.0 * np.sqrt(promise.refitted))


@pytest.mark.slow
def test_a_constant_voltage_and_a_detent_of_an_electrical_period_make_the_same_torque(tmp_path):
    """Truth: a constant voltage u drives a constant current u/R, whose torque turns once in an electrical period.

    The design proposes nothing, and a true record of the fastest steps does not tell them apart either.
    """
    names = ("stepper.detent:7.2deg", "stepper.phase_offset")
    campaign, group = rivals_of_bench("phase_offset", 21, names, tmp_path)
    pool, found = designed(campaign, group)
    (one,) = found.groups
    print(one.reach, [p.now for p in one.pairs])
    assert found.chosen == ()
    assert one.reach < 0.1
    detent, offset = costs_with(campaign, group, pool[-1], "phase_offset", 21)
    print(detent - offset)
    assert abs(detent - offset) < 0.1
