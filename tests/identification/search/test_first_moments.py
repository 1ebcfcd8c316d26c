"""Windows in which starts are judged. Truth: the instant at which the records' commands begin."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.campaign import catalogue_mechanism
from mechid.identification.identifiability.visibility import unseen_parameters
from mechid.identification.identify import identify, make_problem
from mechid.identification.readings.timing import find_long_rest
from mechid.identification.result.outcome import FitOutcome
from mechid.identification.search.box import sample_box
from mechid.identification.search.first_moments import first_window, robust_cost
from mechid.identification.search.multistart import capped_costs
from mechid.identification.search.settings import SEARCH
from paper import constant
from synthetic import COMMANDS, RATE_HZ, campaign, measured, record, truth

FREE = {"value": 0.5, "min": 0.0, "max": 1.0}
FIRST_STEP_S = {name: 1.0 / COMMANDS[name].rate.rates[0] / COMMANDS[name].microsteps for name in COMMANDS}


def rested(name, rest_s, *, seconds=0.5, offset=None, hum=0.0):
    """Return a record that begins before its command, whose time offset is declared as `offset`."""
    rng = np.random.default_rng((5, list(COMMANDS).index(name)))
    y = measured(truth(), COMMANDS[name], rng, seconds=rest_s + seconds, time_offset_s=rest_s)
    y += hum * np.sin(2.0 * np.pi * 50.0 * np.arange(y.size) / RATE_HZ)
    made = record(name, y, COMMANDS[name], time_offset=offset)
    known = replace(made.parameters[0], value=rest_s)
    return made if offset else replace(made, parameters=(known,))


def problem(*records):
    return make_problem(campaign(catalogue_mechanism(), *records), 1)


def window_s(made):
    """Return the first window of a record, s."""
    first, stop = first_window(problem(made).targets[0])
    return first / RATE_HZ, stop / RATE_HZ


@pytest.mark.parametrize("name", ["full_46", "micro_46"])
@pytest.mark.parametrize("rest_s", [0.1, 0.5, 1.5])
def test_the_window_begins_where_the_motion_does(name, rest_s):
    """Truth: the torque changes at the first step commanded, not before."""
    first, stop = window_s(rested(name, rest_s))
    assert rest_s - 0.006 < first < rest_s + FIRST_STEP_S[name] + 0.02
    assert stop - first == pytest.approx(0.06)


@pytest.mark.parametrize("value", [0.1, 0.5, 0.9])
def test_the_motion_counts_and_not_a_time_offset_that_is_to_be_found(value):
    """Truth: the command begins at 0.5 s, wherever its time offset starts."""
    first, _ = window_s(rested("full_46", 0.5, offset=FREE | {"value": value}))
    assert 0.49 < first < 0.54


def test_hum_at_rest_is_no_motion():
    """Truth: 50 Hz of 15 standard deviations of the noise, and full steps from 0.5 s on."""
    first, _ = window_s(rested("full_46", 0.5, hum=0.03))
    assert 0.49 < first < 0.54


@pytest.mark.parametrize("name", list(COMMANDS))
def test_records_that_begin_with_their_command_are_judged_from_their_first_sample(name):
    assert window_s(rested(name, 0.0)) == (0.0, 0.06)


def test_a_short_rest_leaves_the_window_where_it_is():
    """Truth: 20 ms of rest before microsteps leave 40 ms of motion in the window."""
    assert window_s(rested("micro_46", 0.02)) == (0.0, 0.06)


def test_starts_differ_in_cost_behind_half_a_second_of_rest():
    """Truth: the same records without their rest, whose costs order the starts alike."""
    with_rest, without = (problem(*(rested(name, rest) for name in ("full_46", "micro_46"))) for rest in (0.5, 0.0))
    points = list(sample_box(with_rest.space, 32, 0))
    costs = [capped_costs(one, points, targets=one.targets) for one in (with_rest, without)]
    assert np.ptp(costs[0]) > 0.5 * np.ptp(costs[1])
    assert np.corrcoef(np.log(costs))[0, 1] > 0.5


def test_starts_are_simulated_side_by_side_up_to_a_late_window():
    """Truth: each start simulated by itself. The command begins with the record, and its first step after 0.5 s."""
    command = constant(2.0)
    y = np.zeros(round(0.7 * RATE_HZ))
    y[5000:] = np.sin(np.arange(2000))
    slow = problem(record("slow", y, command))
    points = list(sample_box(slow.space, 8, 0))
    assert first_window(slow.targets[0])[0] > 4900
    together = capped_costs(slow, points, targets=slow.targets)
    alone = [capped_costs(slow, [point], targets=slow.targets)[0] for point in points]
    np.testing.assert_allclose(together, alone, rtol=1e-9)


def test_a_rest_too_long_for_the_window_is_said_with_what_to_write():
    """Truth: 3 s of rest; what is written leaves out most of it and keeps the first step."""
    made = rested("full_46", 3.0)
    line = find_long_rest(problem(made).targets[0]).line()
    assert "record full_46" in line
    assert "window_s = [2.9" in line
    assert find_long_rest(problem(rested("full_46", 0.5)).targets[0]) is None


def test_parameters_are_seen_behind_a_rest_longer_than_a_second():
    """Truth: the same record without its rest."""
    with_rest, without = (campaign(catalogue_mechanism(), rested("full_46", rest)) for rest in (1.5, 0.0))
    assert unseen_parameters(with_rest) == unseen_parameters(without)


def test_records_that_begin_half_a_second_early_are_fitted_from_the_catalogue():
    """Truth: the mechanism that made the records."""
    made = campaign(catalogue_mechanism(), *(rested(name, 0.5) for name in COMMANDS))
    fit = identify(made, workers=1)
    assert fit.outcome is FitOutcome.CONVERGED
    for name in ("stepper.torque_constant", "gear.stiffness", "stepper.coil_resistance"):
        p = fit.parameters[name]
        assert abs(p.value - truth().value(name)) < 5.0 * p.std_error, name


@pytest.mark.parametrize("size", [1e-12, 1e-9, 1e-4])
def test_tiny_residuals_are_squared(size):
    """A mechanism at rest under the start's friction leaves next to nothing: that is no cost of exactly zero."""
    r = np.full(100, size)
    assert robust_cost(r) == pytest.approx(100 * size**2, rel=1e-8)


def test_large_residuals_count_by_their_size():
    r = np.array([1e9])
    assert robust_cost(r) == pytest.approx(2.0 * SEARCH.robust_sigmas * 1e9, rel=1e-6)
