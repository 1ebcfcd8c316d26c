"""Torque over the step rate, against what the paper published."""

import numpy as np
import pytest

from mechid.design.rate_map import rate_map
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


def test_the_band_holds_the_mechanisms_it_is_made_of():
    """Truth: quantiles of two curves lie between them."""
    stiff = mechanism(changes={"gear.stiffness": 1500.0})
    command = constant(0.0, microsteps=16, start_angle_deg=0.0)
    low, high = rate_map(mechanism(), [mechanism(), stiff], command, 120.0).spread
    one, other = (rate_map(m, [], command, 120.0).amplitude for m in (mechanism(), stiff))
    assert np.all(low >= np.minimum(one, other) - 1e-12)
    assert np.all(high <= np.maximum(one, other) + 1e-12)
