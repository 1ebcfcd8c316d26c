"""Torque over the step rate, against what the paper published."""

import numpy as np
import pytest

from mechid.budgets.operating_mode import OperatingMode, usual_highest_hz
from mechid.budgets.steady_state import enough_substeps, steady_state
from mechid.designs.rate_map import _spread, _sweep, rate_map
from mechid.designs.settings import RATE
from mechid.plant.flight import to_flight
from mechid.simulation.simulator import Simulator, TimeBase, simulate_run
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
    ends = _spread(np.array([[1.0, 2.0, nan], [3.0, nan, nan], [2.0, 5.0, nan]]))
    np.testing.assert_array_equal(ends, [[1.0, 2.0, nan], [3.0, 5.0, nan]])


RATES = np.array([0.5, 1.5, 2.5, 5.5, 10.5, 20.5, 35.5, 50.5, 70.5, 99.5])
"""Middles of ten bins, each of a full step/s."""


def steady_amplitudes(flying, command, rate):
    """Return half the distance of highest and lowest torque of steady motions at rates across a bin, N m."""
    within = rate + np.linspace(-0.45, 0.45, 7)
    mode = OperatingMode(name="steady", command=command, rates=within, highest_hz=usual_highest_hz(command, 100.0))
    substeps = enough_substeps(flying, mode)
    return [0.5 * np.ptp(steady_state(flying, mode, each, (), substeps).torque) for each in within]


@pytest.mark.slow
@pytest.mark.parametrize("microsteps", [1, *(pytest.param(one, marks=pytest.mark.slow) for one in (2, 16))])
def test_the_torque_in_a_bin_is_that_of_the_largest_steady_motion_in_it(microsteps):
    """Truth: the periodic motions that shooting finds, at any rate of the bin, of a mechanism in flight."""
    flying = to_flight(mechanism())
    command = constant(0.0, microsteps=microsteps, start_angle_deg=45.0 if microsteps == 1 else 0.0)
    found = rate_map(flying, [], command, 120.0)
    for rate in RATES:
        (amplitude,) = found.amplitude[np.isclose(found.rates, rate)]
        steady = steady_amplitudes(flying, command, rate)
        assert amplitude == pytest.approx(max(steady), rel=0.1), (rate, amplitude, steady)


def test_slow_steppings_differ():
    """Truth: at half a step a second every full step strikes alike, and smaller steps strike softer, from any start."""
    full, half, micro = (
        rate_map(mechanism(), [], constant(0.0, microsteps=n, start_angle_deg=0.0), 120.0).amplitude[:3]
        for n in (1, 2, 16)
    )
    assert full == pytest.approx(np.full(3, full[0]), rel=0.01)
    assert np.all(half < 0.7 * full)
    assert np.all(micro < 0.6 * half)


def test_what_the_start_leaves_swinging_is_no_torque_of_a_rate():
    """Truth: the bench run at rates of the first bin for 24 s, all but the last third, two of its periods, left out."""
    bench, command = mechanism(), constant(0.0, microsteps=16, start_angle_deg=0.0)
    steady = []
    for rate in (0.5, 0.6, 0.7, 0.8, 0.9, 1.0):
        simulator = Simulator(bench.plant, constant(rate, microsteps=16, start_angle_deg=0.0), TimeBase(1e4, 240_000))
        torque = simulate_run(simulator.run(bench.kernel_values())).torque
        steady.append(0.5 * np.ptp(torque[160_000:]))
        assert 0.5 * np.ptp(torque) > 1.3 * steady[-1]
    assert rate_map(bench, [], command, 120.0).amplitude[0] < 1.2 * max(steady)


@pytest.mark.parametrize(
    ("highest", "steps", "electrical"), [(120.0, 4, 4), (12.0, 4, 4), (0.3, 4, 4), (120.0, 200, 4), (20.0, 50, 6)]
)
def test_every_bin_holds_a_whole_period(highest, steps, electrical):
    """Truth: the steps in a bin are the mean rate times the time spent there."""
    sweep = _sweep(highest, steps, electrical)
    seconds, middle = np.diff(sweep.times_s), 0.5 * (sweep.edges[1:] + sweep.edges[:-1])
    held = middle * seconds
    assert held.min() >= electrical * (1.0 - 1e-9)
    assert np.all((held >= steps * (1.0 - 1e-9)) | (seconds >= RATE.longest_s * (1.0 - 1e-9)))
    assert sweep.times_s[-1] < 3600.0
    bins = sweep.bins(0, sweep.base.samples)
    assert bins[[0, -1]].tolist() == [-1, middle.size - 1]
    assert np.sum(bins < 0) / RATE.sample_rate_hz == pytest.approx(RATE.settled_s)
