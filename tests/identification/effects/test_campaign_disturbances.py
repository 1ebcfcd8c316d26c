"""Disturbances that a campaign may have, and those of an earlier fit. Truth: what its file declares and excludes."""

from dataclasses import replace

import pytest

from disturbed_bench import written
from mechid.campaign import load_campaign
from mechid.campaign.identify_options import DISTURBANCES
from mechid.identification.effects.campaign_disturbances import (
    Declared,
    possible_disturbances,
    restore_found_records,
    widen_priors,
)
from mechid.identification.effects.disturbance import with_disturbances
from mechid.identification.effects.settings import PRIORS
from mechid.identification.identify import make_problem
from mechid.parameter import Status


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """Return a campaign of three records that steps drive."""
    return written(tmp_path_factory.mktemp("bench"), {})[0]


def names(campaign):
    return {one.name for one in possible_disturbances(make_problem(campaign, 1), campaign)}


def test_what_the_file_excludes_is_not_possible(bench):
    every = set(DISTURBANCES) - {"mains", "record.gain"}  # no hum is seen; the mechanism has no transducer
    assert names(bench) == every
    for asked, expected in (("none", set()), (("clock", "record.delay"), {"clock", "record.delay"})):
        assert names(replace(bench, options=replace(bench.options, disturbances=asked))) == expected


def test_a_record_alone_differs_from_no_other(bench):
    """Truth: of one record a supply is the mechanism's, and its clock that of all."""
    assert names(replace(bench, records=bench.records[:1])) == {"clock", "record.delay"}


def test_priors_are_as_wide_as_the_settings_say(bench):
    some = {one.name: one for one in possible_disturbances(make_problem(bench, 1), bench)}
    (clock,) = some["clock"].parameters
    assert (clock.value, clock.sigma, clock.max) == (0.0, PRIORS.clock_ppm, PRIORS.reach * PRIORS.clock_ppm)
    for p in some["record.voltage"].parameters:
        assert p.sigma == pytest.approx(0.02 * p.value)
        assert p.replaces == "stepper.peak_voltage"


def widened_at(bench, name, sigmas, *, edge=2.0, factor=4.0, times=1):
    """Return a disturbance whose first value stands so many of its deviations off, widened, and it before."""
    plain = make_problem(bench, 1)
    before = one = next(one for one in possible_disturbances(plain, bench) if one.name == name)
    for _ in range(times):
        problem = with_disturbances(plain, [one])
        p = one.parameters[0]
        q = problem.coordinates.point({p.name: p.value + sigmas * p.sigma})
        (one,) = widen_priors((one,), problem, q, edge, factor)
    return one, before


def test_a_prior_at_whose_edge_a_value_stands_becomes_wider(bench):
    """Truth: four times the widths, and ranges within what hardware may be off, by hand."""
    for name, sigmas in (("clock", 1.9), ("record.delay", -1.9)):
        one, before = widened_at(bench, name, sigmas)
        assert one is before
    (clock,) = widened_at(bench, "clock", 2.1)[0].parameters
    assert (clock.sigma, clock.min, clock.max) == (1200.0, -5000.0, 5000.0)
    for p in widened_at(bench, "record.delay", -2.1)[0].parameters:
        assert (p.sigma, p.min, p.max) == pytest.approx((1.2e-3, -6e-3, 6e-3))
    for p in widened_at(bench, "record.voltage", 2.1)[0].parameters:
        assert (p.sigma / p.value, p.min / p.value, p.max / p.value) == pytest.approx((0.08, 0.8, 1.2))


def test_no_prior_becomes_wider_than_hardware_is(bench):
    """Truth: 20 % of a supply, at which it stays."""
    voltage, _ = widened_at(bench, "record.voltage", 2.5, times=2)
    assert [p.sigma / p.value for p in voltage.parameters] == pytest.approx([0.2] * 3)
    again, _ = widened_at(bench, "record.voltage", 2.5, times=3)
    assert again.own == voltage.own


def test_a_value_of_a_mechanism_that_is_free_keeps_the_range_of_the_file(bench):
    """Truth: the winding's resistance, which the file lets vary from 5 to 20 ohm."""
    one, before = widened_at(bench, "record.temperature", 2.1)
    for wider, p in zip(one.parameters, before.parameters, strict=True):
        assert (wider.min, wider.max) == (p.min, p.max)
        assert wider.sigma == pytest.approx(4.0 * p.sigma)


@pytest.mark.parametrize("name", ["clock", "record.clock", "record.delay", "record.voltage", "record.temperature"])
def test_what_declares_a_disturbance_takes_its_place(bench, name):
    """Truth: declared by its TOML it is free at the values written, and no longer possible."""
    one = next(one for one in possible_disturbances(make_problem(bench, 1), bench) if one.name == name)
    values = {p.name: p.value + 0.5 * p.sigma for p in one.parameters}
    path = bench.path.with_name("declared.toml")
    path.write_text(bench.path.read_text() + "\n" + one.toml(values))
    declared = load_campaign(path)
    free = {p.name: p for record in declared.records for p in record.parameters if p.is_free}
    assert {n: free[n].value for n in values} == pytest.approx(values)
    assert name not in names(declared)


def test_a_disturbance_found_earlier_is_free_again_within_its_bounds(bench):
    found = {
        "campaign.clock_ppm": Declared.from_file(0.0, -1500.0, 1500.0, 300.0),
        "record.half.peak_voltage": Declared.from_file(10.0, None, None, None),
    }
    back = {r.name: {p.name: p for p in r.parameters if p.is_free} for r in restore_found_records(bench, found).records}
    assert set(back["full"]) == {"campaign.clock_ppm"}
    assert set(back["half"]) == set(found)
    own = back["half"]["record.half.peak_voltage"]
    assert (own.value, own.status, own.replaces) == (10.0, Status.FREE, "stepper.peak_voltage")
    assert own.max == float("inf")
