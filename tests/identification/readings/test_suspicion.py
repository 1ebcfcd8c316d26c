"""Suspicions about records that contradict their declaration, by their own spectra."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from mechid.campaign import catalogue_mechanism
from mechid.command import RateProfile
from mechid.identification.identify import identify, make_problem
from mechid.identification.output_error.declaration import DECLARED, Reading
from mechid.identification.readings.detectors import declaration_warnings
from mechid.identification.readings.finding import DeclaredRecords
from mechid.identification.readings.misreading import find_misreadings
from mechid.identification.readings.suspicion import Suspicions, suspect
from mechid.identification.result.grade import FitOutcome
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


def declared(bench):
    """Return the records of a campaign as they are declared."""
    return DeclaredRecords(bench, make_problem(bench, 1))


def seen(bench):
    """Return the suspicions about a campaign."""
    records = declared(bench)
    return suspect(records.problem, records.spectra)


def at_rate(name, rate):
    """Return a record's command at another rate."""
    return replace(COMMANDS[name], rate=RateProfile.constant(rate))


@pytest.mark.parametrize("seed", [7, 8])
def test_nothing_is_said_of_records_that_are_as_declared(seed):
    """Truth: records made as declared, by a mechanism off the catalogue by factors."""
    bench = made(seed=seed)
    assert seen(bench) == Suspicions()
    assert declaration_warnings(bench) == ()


@pytest.mark.parametrize("scale", [1e-3, 1e-2, 1e2, 1e3])
def test_a_unit_of_one_record_is_told(scale):
    """Truth: the factor by which one record's torque was divided."""
    assert seen(made(data={"full_23": torque("full_23") / scale})).readings == {"full_23": Reading(scale=scale)}


@pytest.mark.parametrize("scale", [1e-3, pytest.param(1e3, marks=pytest.mark.slow)])
def test_a_unit_of_all_records_is_told_and_not_changed(scale):
    """Truth: the factor by which all torques were divided."""
    bench = made(data={name: torque(name) / scale for name in NAMES})
    assert seen(bench) == Suspicions(common_scale=scale)
    (line,) = declaration_warnings(bench)
    assert line.startswith("all records")
    assert ('unit = "mN*m"' in line) == (scale == 1e-3)


@pytest.mark.parametrize("name", ["full_46", "micro_92"])
def test_another_stepping_is_told(name):
    """Truth: how the record was stepped, at the rate that is declared."""
    rate = COMMANDS[name].rate.rates[0]
    wrong = constant(rate, microsteps=16, start_angle_deg=0.0) if name == "full_46" else constant(rate)
    (found,) = seen(made(commands={name: wrong})).readings.values()
    assert found.stepping == COMMANDS[name].stepping


def test_another_rate_is_told():
    """Truth: the rate of the record's steps; its lines tell it to a part in a thousand."""
    sight = seen(made(commands={"full_46": at_rate("full_46", 31.0)}))
    assert sight.readings["full_46"].rate.rates[0] == pytest.approx(46.0, rel=1e-3)
    assert not sight.doubtful


@pytest.mark.parametrize(
    "pair", [("full_46", "micro_46"), pytest.param(("full_23", "micro_92"), marks=pytest.mark.slow)]
)
def test_two_records_swapped_are_told(pair):
    """Truth: the data of two records exchanged."""
    one, other = pair
    bench = made(data={one: torque(other), other: torque(one)})
    sight = seen(bench)
    assert {name: taken.swapped for name, taken in sight.readings.items()} == {one: other, other: one}
    (finding,) = find_misreadings(declared(bench))
    assert finding.is_confirmed
    assert f"records {one} and {other}" in finding.line()


def test_a_record_is_read_so_from_the_first_stage_on():
    """Truth: one record in mN m and declared in N m; the mechanism that made all."""
    bench = made(data={"micro_46": 1e3 * torque("micro_46")}, start=displaced(truth(), FACTORS))
    fit = identify(bench, workers=1)
    assert fit.outcome is FitOutcome.CONVERGED
    assert fit.warnings[0].startswith("record micro_46: its spectrum")
    assert {name: r.reading for name, r in fit.records.items() if r.reading != DECLARED} == {
        "micro_46": Reading(scale=1e-3)
    }
    for name in FACTORS:
        p = fit.parameters[name]
        assert abs(p.value - truth().value(name)) < 5.0 * p.std_error, name
