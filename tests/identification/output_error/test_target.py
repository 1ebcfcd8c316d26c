"""Targets of a fit. Truth: the record that they are made from, and the definitions by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from mechid.identification.output_error.noise_level import NoiseSource
from mechid.identification.output_error.target import TargetChannel, latest_of, target_of, time_offset_of
from mechid.signal.autoregression import Autoregression
from synthetic import COMMANDS, RATE_HZ, record

SAMPLES = 500
OFFSET = "record.full_46.time_offset_s"


@pytest.fixture
def target():
    return target_of(record("full_46", np.random.default_rng(3).standard_normal(SAMPLES), COMMANDS["full_46"]))


def channel(**changes):
    own = {"quantity": "torque", "measured": np.zeros(SAMPLES), "sigma": 2.0, "rounding": 1.0}
    return TargetChannel(**{**own, **changes})


def test_a_target_has_its_records_samples_and_clock(target):
    assert (target.name, target.samples, target.quantities) == ("full_46", SAMPLES, ("torque",))
    assert target.base.sample_rate_hz == RATE_HZ
    assert target.command == COMMANDS["full_46"]
    assert target.leading.rests_on in tuple(NoiseSource)


def test_burn_in_does_not_count():
    """Truth: 10 ms at the sample rate."""
    own = replace(record("full_46", np.zeros(SAMPLES), COMMANDS["full_46"]), burn_in_s=0.01)
    made = target_of(own)
    assert made.burn_in == round(0.01 * RATE_HZ)
    np.testing.assert_array_equal(made.leading.rejected, np.arange(made.burn_in))


def test_the_beginning_of_a_target_is_its_first_samples(target):
    spoilt = target.map_channels(lambda c: replace(c, rejected=np.array([3, 90, 200])))
    first = spoilt.truncate(100)
    assert (first.samples, first.base.samples) == (100, 100)
    np.testing.assert_array_equal(first.leading.measured, target.leading.measured[:100])
    np.testing.assert_array_equal(first.leading.rejected, [3, 90])
    np.testing.assert_array_equal(spoilt.leading.rejected_within((80, 201)), [10, 120])


def test_a_target_that_no_channel_changes_is_the_same_one(target):
    assert target.map_channels(lambda c: c) is target


def test_a_prefilter_takes_rounding_for_colour():
    """Truth: rounding has a quarter of the variance of white noise; behind a prefilter the rest is its own."""
    plain, filtered = channel(), channel(prefilter=Autoregression(np.array([1.0, -0.5]), 0.7))
    assert (plain.rounding_share, plain.scale, plain.order) == (0.25, 2.0, 0)
    assert (filtered.rounding_share, filtered.scale, filtered.order) == (0.0, 0.7, 1)


@pytest.mark.parametrize(("linear", "turns", "columns"), [(0, (), 0), (2, (), 2), (1, (0.005, 0.01), 5)])
def test_each_line_projects_out_a_cosine_and_a_sine(linear, turns, columns):
    assert channel(linear=linear, turns=turns).projected_columns == columns


def test_a_free_time_offset_moves_the_edges_within_reach(target):
    """Truth: its bounds; held, its value."""
    free = target.with_time_offset(time_offset_of("full_46", 0.01, (-0.03, 0.02)))
    assert free.latest_s == latest_of(free.own, free.base) == 0.03
    held = free.fix_parameters({OFFSET: 0.01})
    assert {q.name for q in free.free_parameters} == {OFFSET}
    assert held.free_parameters == ()
    assert math.isclose(held.latest_s, 0.01)
