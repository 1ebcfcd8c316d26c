"""Times that a record shows by itself. Truth: rows that were taken out, rates that the motor was stepped at."""

import re
from dataclasses import replace

import numpy as np
import pytest

from mechid.command import RateProfile
from mechid.identification.output_error.target import target_of
from mechid.identification.readings.timing import find_lost_rows, find_sweep_rate
from mechid.parameter import Status
from recovery.campaigns import campaign, record_of
from recovery.mechanisms import FAMILIES
from wrong.bench import RUNS, measured_torque


def target(name, torque=None, **changes):
    command = replace(RUNS[name].command, **changes)
    return target_of(record_of(name, measured_torque(name) if torque is None else torque, command))


def without(name, first, rows):
    return np.delete(measured_torque(name), slice(first, first + rows))


@pytest.mark.parametrize("name", ["full_46", "full_23", "micro_46", "micro_92"])
def test_nothing_is_lost_of_a_whole_record(name):
    assert find_lost_rows(target(name)) is None


@pytest.mark.parametrize(("first", "rows"), [(5000, 50), (3000, 20), (7000, 130)])
def test_rows_that_are_lost_are_counted_and_placed(first, rows):
    """Truth: as many rows as were taken out, within a period of 87 ms of where that was."""
    line = find_lost_rows(target("full_46", without("full_46", first, rows))).line()
    assert "ahead" in line
    assert float(re.search(r"some (\d+) rows", line)[1]) == pytest.approx(rows, abs=1)
    assert float(re.search(r"about (\S+) s on", line)[1]) == pytest.approx(1e-4 * first, abs=4.0 / 46.0)


def test_rows_that_are_there_twice_are_behind():
    y = measured_torque("full_46")
    line = find_lost_rows(target("full_46", np.insert(y, 5000, y[4950:5000]))).line()
    assert "behind" in line
    assert "some 50 rows are too many" in line


def test_a_step_that_the_motor_lost_is_no_lost_row():
    """Truth: the motion goes on a whole step of 1/46 s later, as it does where a step was lost."""
    assert find_lost_rows(target("full_46", without("full_46", 5000, round(1e4 / 46.0)))) is None


def test_another_rate_is_no_jump():
    """Truth: 46 steps a second, declared 46.1: each period lies a little further behind."""
    assert find_lost_rows(target("full_46", rate=RateProfile.constant(46.1))) is None


def test_a_motion_that_settles_is_no_jump():
    """Truth: simulated without a gap; its mechanism comes to its steady phase by a sample in each of five turns."""
    family = FAMILIES[1]
    settling = campaign(family.catalogue(), family.truth(118), 118, "all").record("micro_2res")
    assert find_lost_rows(target_of(settling)) is None


@pytest.mark.parametrize("factor", [0.98, 0.99, 1.01, 1.03])
def test_a_sweep_of_other_rates_is_told_by_how_much(factor):
    """Truth: the ratio of the rates that the motor was stepped at to the declared ones."""
    declared = RateProfile.through(
        [(t, factor * r) for t, r in zip(RUNS["sweep"].rate.times_s, RUNS["sweep"].rate.rates, strict=True)]
    )
    line = find_sweep_rate(target("sweep", rate=declared)).line()
    assert float(re.search(r"some (\S+) times", line)[1]) == pytest.approx(1.0 / factor, abs=3e-3)


def test_nothing_is_said_of_the_sweep_as_it_was_run():
    assert find_sweep_rate(target("sweep")) is None


def test_a_late_trigger_within_its_bounds_is_no_other_rate():
    """Truth: the sweep as it was run, its command 60 ms later than the file's start of the trigger."""
    late_s = 0.06
    wrong = target("sweep", np.concatenate([np.zeros(round(1e4 * late_s)), measured_torque("sweep")]))
    assert find_sweep_rate(wrong) is not None
    free = replace(wrong.time_offset, status=Status.FREE, min=-0.08, max=0.08)
    assert find_sweep_rate(wrong.with_time_offset(free)) is None


def test_a_sweep_that_shows_noise_alone_says_nothing():
    noise = np.random.default_rng(1).standard_normal(measured_torque("sweep").size)
    assert find_sweep_rate(target("sweep", 2e-3 * noise)) is None
