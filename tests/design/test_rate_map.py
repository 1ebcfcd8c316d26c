"""Torque over the step rate, against what the paper published."""

import numpy as np
import pytest

from mechid.designs.rate_map import _ends, rate_map
from paper import constant, mechanism, without_detent_phases


@pytest.mark.parametrize("made", [mechanism, without_detent_phases], ids=["with phases", "as published"])
def test_full_steps_peak_where_the_paper_found_them(made):
    """Truth: published, Fig. 4 and section 5.1: high amplitudes at 23, 46 and 92 steps/s; bins are one step/s wide."""
    found = rate_map(made(), [], constant(0.0), 120.0)
    rates = np.array([rate for rate, _ in found.peaks])
    for published in (23.0, 46.0, 92.0):
        assert np.min(np.abs(rates - published)) <= 1.5, rates
    assert abs(rates[0] - 46.0) <= 1.5


def test_microsteps_peak_at_92_alone():
    """Truth: published: the microstep sweep is largest at 92 steps/s, 0.34 N m by an independent simulator."""
    found = rate_map(mechanism(), [], constant(0.0, microsteps=16, start_angle_deg=0.0), 120.0)
    (rate, amplitude), *_ = found.peaks
    assert abs(rate - 92.0) <= 1.5
    assert amplitude == pytest.approx(0.34, rel=0.02)


def test_the_band_is_from_the_least_to_the_largest_of_the_mechanisms_the_one_believed_among_them():
    """Truth: the curves one by one. The one believed has neither a second detent nor more torque than any other."""
    believed = mechanism(changes={"stepper.detent.1.amplitude": 0.0})
    others = [mechanism(changes={"gear.stiffness": stiffness}) for stiffness in (900.0, 1500.0)]
    command = constant(0.0, microsteps=16, start_angle_deg=0.0)
    found = rate_map(believed, others, command, 120.0)
    each = np.array([rate_map(m, [], command, 120.0).amplitude for m in (believed, *others)])
    np.testing.assert_array_equal(found.amplitude, each[0])
    np.testing.assert_array_equal(found.spread, [each.min(axis=0), each.max(axis=0)])
    assert np.all((found.spread[0] <= found.amplitude) & (found.amplitude <= found.spread[1]))
    assert np.mean(found.amplitude < np.quantile(each, 0.1, axis=0)) > 0.3
    assert found.mechanisms == 3


def test_a_mechanism_that_cannot_be_simulated_leaves_the_band_to_the_others():
    """Truth: of curves that are not there neither the least nor the largest is known."""
    nan = np.nan
    ends = _ends(np.array([[1.0, 2.0, nan], [3.0, nan, nan], [2.0, 5.0, nan]]))
    np.testing.assert_array_equal(ends, [[1.0, 2.0, nan], [3.0, 5.0, nan]])
