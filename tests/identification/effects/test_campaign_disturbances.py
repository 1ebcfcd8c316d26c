"""Disturbances that a campaign may have, and those of an earlier fit. Truth: what its file declares and excludes."""

from dataclasses import replace

import pytest

from disturbed_bench import written
from mechid.campaign import load_campaign
from mechid.campaign.identify_options import DISTURBANCES
from mechid.identification.effects.campaign_disturbances import Declared, possible, recalled
from mechid.identification.effects.settings import PRIORS
from mechid.identification.identify import make_problem
from mechid.parameter import Status


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """Return a campaign of three records that steps drive."""
    return written(tmp_path_factory.mktemp("bench"), {})[0]


def names(campaign):
    return {one.name for one in possible(make_problem(campaign, 1), campaign)}


def test_what_the_file_excludes_is_not_possible(bench):
    every = set(DISTURBANCES) - {"mains", "record.gain"}  # no hum is seen; the mechanism has no transducer
    assert names(bench) == every
    for asked, expected in (("none", set()), (("clock", "record.delay"), {"clock", "record.delay"})):
        assert names(replace(bench, options=replace(bench.options, disturbances=asked))) == expected


def test_a_record_alone_differs_from_no_other(bench):
    """Truth: of one record a supply is the mechanism's, and its clock that of all."""
    assert names(replace(bench, records=bench.records[:1])) == {"clock", "record.delay"}


def test_priors_are_as_wide_as_the_settings_say(bench):
    some = {one.name: one for one in possible(make_problem(bench, 1), bench)}
    (clock,) = some["clock"].parameters
    assert (clock.value, clock.sigma, clock.max) == (0.0, PRIORS.clock_ppm, PRIORS.reach * PRIORS.clock_ppm)
    for p in some["record.voltage"].parameters:
        assert p.sigma == pytest.approx(0.02 * p.value)
        assert p.replaces == "stepper.peak_voltage"


@pytest.mark.parametrize("name", ["clock", "record.clock", "record.delay", "record.voltage", "record.temperature"])
def test_what_declares_a_disturbance_takes_its_place(bench, name):
    """Truth: declared by its TOML it is free at the values written, and no longer possible."""
    one = next(one for one in possible(make_problem(bench, 1), bench) if one.name == name)
    values = {p.name: p.value + 0.5 * p.sigma for p in one.parameters}
    path = bench.path.with_name("declared.toml")
    path.write_text(bench.path.read_text() + "\n" + one.toml(values))
    declared = load_campaign(path)
    free = {p.name: p for record in declared.records for p in record.parameters if p.is_free}
    assert {n: free[n].value for n in values} == pytest.approx(values)
    assert name not in names(declared)


def test_a_disturbance_found_earlier_is_free_again_within_its_bounds(bench):
    found = {
        "campaign.clock_ppm": Declared.bounded(0.0, -1500.0, 1500.0, 300.0),
        "record.half.peak_voltage": Declared.bounded(10.0, None, None, None),
    }
    back = {r.name: {p.name: p for p in r.parameters if p.is_free} for r in recalled(bench, found).records}
    assert set(back["full"]) == {"campaign.clock_ppm"}
    assert set(back["half"]) == set(found)
    own = back["half"]["record.half.peak_voltage"]
    assert (own.value, own.status, own.replaces) == (10.0, Status.FREE, "stepper.peak_voltage")
    assert own.max == float("inf")
