"""Emission before and after. Truth: lines simulated by themselves, a unit that is the mechanism itself."""

import numpy as np
import pytest

from mechid.budgets.flight_entry import Flight
from mechid.budgets.flying_mechanism import flying_estimate
from mechid.quiet_drives.improvement import moved_mechanisms
from mechid.quiet_drives.periodic_torque import PeriodicTorque


def test_the_gain_is_that_of_the_lines(found, mechanism):
    gain = found.improvement.gains[0]
    before, after = (PeriodicTorque(mechanism, 30.0).lines(table).level for table in (found.nominal, found.table))
    assert gain.gain_db == pytest.approx(20.0 * np.log10(before / after), abs=0.3)
    assert gain.gain_db > 6.0
    assert gain.bound_db <= gain.gain_db + 0.1


def test_a_unit_that_is_the_mechanism_itself_gains_the_same(found):
    (gains,) = found.improvement.units.values()
    assert gains[0].gain_db == pytest.approx(found.improvement.gains[0].gain_db, abs=0.3)


def test_the_chosen_lines_have_bounds_above_their_amplitudes(found):
    assert {one.order for one in found.improvement.after} >= {0.5, 1.0, 2.0}
    assert all(one.bound >= 0.9 * one.amplitude for one in found.improvement.after)


def test_each_estimated_parameter_has_a_sensitivity(found, fit):
    assert set(found.improvement.sensitivity) == set(flying_estimate(fit, Flight()).names)


def test_a_deviation_beyond_a_physical_limit_is_shortened(fit):
    estimate = flying_estimate(fit, Flight())
    move = np.zeros(len(estimate.names))
    k = estimate.names.index("friction.coulomb")
    move[k] = -1.5 * estimate.mechanism.value("friction.coulomb")
    (moved,) = moved_mechanisms(estimate, np.array([move]))
    assert moved.value("friction.coulomb") == pytest.approx(0.25 * estimate.mechanism.value("friction.coulomb"))
