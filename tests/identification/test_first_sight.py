"""Records that are plainly not as declared: told before the search by their own spectra."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from mechid.campaign import catalogue_mechanism
from mechid.command import RateProfile
from mechid.identification.contradiction.first_sight import FirstSight, first_sight
from mechid.identification.contradiction.first_sight_text import first_sight_lines
from mechid.identification.contradiction.record_sight import sight_of
from mechid.identification.identify import identify, make_problem
from mechid.identification.output_error.declaration import DECLARED, Reading
from mechid.identification.result.outcome import FitOutcome
from mechid.identification.stages.first_seen import declaration_warnings
from paper import constant
from synthetic import COMMANDS, campaign, displaced, measured, record, truth

NAMES = ("full_46", "full_23", "micro_46", "micro_92")
SECONDS = 1.0
FACTORS = {"gear.stiffness": 1.1, "stepper.torque_constant": 0.95}


@cache
def torque(name, seed=7):
    """Return what the demo's mechanism gives in a record, with noise, offset and drift."""
    return measured(truth(), COMMANDS[name], np.random.default_rng((seed, NAMES.index(name))), seconds=SECONDS)


def made(*, data=None, commands=None, start=None, seed=7):
    """Return a campaign from the catalogue whose records have other data, or other commands, than they should."""
    y = {name: torque(name, seed) for name in NAMES} | (data or {})
    driven = {**COMMANDS, **(commands or {})}
    return campaign(start or catalogue_mechanism(), *(record(name, y[name], driven[name]) for name in NAMES))


def seen(bench):
    """Return the first sight of a campaign."""
    return first_sight(make_problem(bench, 1))


def at_rate(name, rate):
    """Return a record's command at another rate."""
    return replace(COMMANDS[name], rate=RateProfile.constant(rate))


@pytest.mark.parametrize("seed", [7, 8])
def test_nothing_is_said_of_records_that_are_as_declared(seed):
    """Truth: records made as declared, by a mechanism off the catalogue by factors."""
    bench = made(seed=seed)
    assert seen(bench) == FirstSight()
    assert declaration_warnings(bench) == ()


@pytest.mark.parametrize("scale", [1e-3, 1e-2, 1e2, 1e3])
def test_a_unit_of_one_record_is_told(scale):
    """Truth: the factor by which one record's torque was divided."""
    assert seen(made(data={"full_23": torque("full_23") / scale})).otherwise == {"full_23": Reading(scale=scale)}


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_a_unit_of_all_records_is_told_and_not_changed(scale):
    """Truth: the factor by which all torques were divided."""
    bench = made(data={name: torque(name) / scale for name in NAMES})
    assert seen(bench) == FirstSight(common_scale=scale)
    (line,) = declaration_warnings(bench)
    assert line.startswith("all records")
    assert ('unit = "mN*m"' in line) == (scale == 1e-3)


@pytest.mark.parametrize("name", ["full_46", "micro_92"])
def test_another_stepping_is_told(name):
    """Truth: how the record was stepped, at the rate that is declared."""
    rate = COMMANDS[name].rate.rates[0]
    wrong = constant(rate, microsteps=16, start_angle_deg=0.0) if name == "full_46" else constant(rate)
    (found,) = seen(made(commands={name: wrong})).otherwise.values()
    assert found.stepping == COMMANDS[name].stepping


def test_another_rate_is_told():
    """Truth: the rate of the record's steps; its lines tell it to a part in a thousand."""
    sight = seen(made(commands={"full_46": at_rate("full_46", 31.0)}))
    assert sight.otherwise["full_46"].rate.rates[0] == pytest.approx(46.0, rel=1e-3)
    assert sight.sure == sight.otherwise


@pytest.mark.parametrize("pair", [("full_46", "micro_46"), ("full_23", "micro_92")])
def test_two_records_swapped_are_told(pair):
    """Truth: the data of two records exchanged."""
    one, other = pair
    bench = made(data={one: torque(other), other: torque(one)})
    sight = seen(bench)
    assert {name: taken.swapped for name, taken in sight.otherwise.items()} == {one: other, other: one}
    (line,) = first_sight_lines(bench, sight, used=True)
    assert f"records {one} and {other}" in line


def test_a_record_is_read_so_from_the_first_stage_on():
    """Truth: one record in mN m and declared in N m; the mechanism that made all."""
    bench = made(data={"micro_46": 1e3 * torque("micro_46")}, start=displaced(truth(), FACTORS))
    fit = identify(bench, workers=1)
    assert fit.outcome is FitOutcome.CONVERGED
    assert fit.warnings[0].startswith("record micro_46: its spectrum")
    assert {name: r.taken for name, r in fit.records.items() if r.taken != DECLARED} == {
        "micro_46": Reading(scale=1e-3)
    }
    for name in FACTORS:
        p = fit.parameters[name]
        assert abs(p.value - truth().value(name)) < 5.0 * p.std_error, name


def test_what_is_taken_is_written_and_read_again():
    """Truth: the readings that were written down."""
    for taken in (
        Reading(scale=1e-3, polarity=-1),
        Reading(rate=RateProfile.constant(46.0), stepping="full", microsteps=1, swapped="a", start_angle_deg=45.0),
        Reading(rate=RateProfile.through([(0.0, 0.0), (8.0, 110.0)])),
    ):
        assert Reading.from_dict(taken.to_dict()) == taken


def test_a_further_reading_is_beside_the_first():
    """Truth: two faults of one record, found one after the other."""
    found = Reading(scale=1e-3, polarity=-1).beside(Reading(polarity=-1, start_angle_deg=45.0))
    assert found == Reading(scale=1e-3, start_angle_deg=45.0)


def test_a_low_pass_far_above_a_record_changes_nothing():
    """Truth: the distance without one, also of a record at 1 kHz, all of whose frequencies are looked at."""
    short = record("full_46", torque("full_46")[:2000:10], COMMANDS["full_46"], rate_hz=1000.0)
    sight = sight_of(make_problem(campaign(catalogue_mechanism(), short), 1).targets[0])
    np.testing.assert_allclose(
        sight.distances_behind(2.0 * sight.power, [1e9]), sight.distances(2.0 * sight.power, [1.0])
    )
