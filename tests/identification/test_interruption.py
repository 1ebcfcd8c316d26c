"""Ending a fit that is at work. Truth: it is asked once a block of samples, and ends where it is told to."""

import threading
from collections import Counter

import pytest

import synthetic
from mechid.analysis import validate
from mechid.identification.computation.parallel import map_tasks
from mechid.identification.identify import identify
from mechid.identification.result.grade import FitOutcome
from mechid.simulation.interruption import check_interruption, interrupt_by
from mechid.simulation.simulator import PLAIN_BLOCK
from synthetic import displaced

SECONDS = 60.0


class Stop(BaseException):
    """Ends a fit, as a cancelled one of the explorer does."""


class Asked:
    """Counts by stage how often it is asked; at number `last` it begins to say stop."""

    def __init__(self, last=None, error=Stop):
        self.last, self.error, self.lock = last, error, threading.Lock()
        self.stage, self.number, self.by_stage, self.first = "start", 0, Counter(), {}

    def __call__(self):
        with self.lock:
            self.number += 1
            self.by_stage[self.stage] += 1
            self.first.setdefault(self.stage, self.number)
            if self.last is not None and self.number >= self.last:
                raise self.error

    def listen(self, progress):
        self.stage = progress.stage


@pytest.fixture(scope="module")
def campaign():
    start = displaced(synthetic.truth(), {"gear.stiffness": 1.1, "gear.damping": 0.8})
    return synthetic.bench(start, synthetic.truth(), "full_46", "micro_92", seed=5, seconds=0.3)


def fitted(campaign, asked, workers):
    """Fit, then judge: both are to be ended."""
    with interrupt_by(asked):
        fit = identify(campaign, workers=workers, listener=asked.listen)
        asked.stage = "verdict"
        validate(campaign, fit)
    return fit


@pytest.fixture(scope="module")
def whole(campaign):
    """Return what a fit that goes to its end is asked, and what it finds."""
    asked = Asked()
    return asked, fitted(campaign, asked, 1)


@pytest.mark.parametrize("seconds", [0.3, 2.0])
def test_a_simulation_asks_once_a_block_of_samples(seconds):
    asked = Asked()
    made = synthetic.bench(synthetic.truth(), synthetic.truth(), "full_46", seed=1, seconds=seconds)
    record = made.records[0]
    with interrupt_by(asked):
        synthetic.torque_of(synthetic.truth(), record.command, record.data.samples)
    assert asked.number == -(-record.data.samples // PLAIN_BLOCK)


def test_being_asked_changes_no_number(campaign, whole):
    _, fit = whole
    plain = identify(campaign, workers=1)
    assert plain.outcome is FitOutcome.CONVERGED
    for name, p in plain.parameters.items():
        assert (fit.parameters[name].value, fit.parameters[name].std_error) == (p.value, p.std_error)


def _late(asked):
    """Return the number of the last question in the standard errors."""
    return asked.first["verdict"] - 1


@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_it_ends_in_each_stage_where_it_is_told_to(campaign, whole, workers):
    """Also in the standard errors, which follow the last report: each thread asks a few times more at most."""
    asked, _ = whole
    assert {"multi-start", "gated growth", "joint fit", "noise re-estimated", "verdict"} <= set(asked.first)
    assert asked.by_stage["noise re-estimated"] > 50  # 30 draws of two records, eight of them asked together
    for last in (1, *asked.first.values(), _late(asked)):
        ended = Asked(last)
        with pytest.raises(Stop):
            fitted(campaign, ended, workers)
        assert last <= ended.number <= last + 4 * (workers - 1)


def test_ctrl_c_in_the_standard_errors_keeps_what_was_found(campaign, whole):
    """Truth: the optimum of the fit that went to its end."""
    asked, fit = whole

    class Once(Asked):
        def __call__(self):
            if self.number < self.last:
                super().__call__()

    with interrupt_by(Once(_late(asked), KeyboardInterrupt)):
        stopped = identify(campaign, workers=1)
    assert stopped.outcome is FitOutcome.INTERRUPTED
    for name, p in fit.parameters.items():
        assert (stopped.parameters[name].value, stopped.parameters[name].std_error) == (p.value, p.std_error)


def test_tasks_that_nobody_waits_for_end_with_their_next_block():
    """Truth: the other task is in a loop without an end of its own."""
    began, ended = threading.Event(), threading.Event()

    def one(task):
        if task == "fails":
            assert began.wait(SECONDS)
            raise ValueError(task)
        began.set()
        try:
            while True:
                check_interruption()
        finally:
            ended.set()

    with pytest.raises(ValueError, match="fails"):
        map_tasks(one, ["goes on", "fails"], 2)
    assert ended.wait(SECONDS)


def test_a_task_that_fails_is_what_is_raised_and_no_other_begins_after_it():
    """Truth: what has begun: the other task of two at work ends once the first has failed, the rest find that."""
    began = []

    def one(task):
        began.append(task)
        if task == "fails":
            raise ValueError(task)
        while True:
            check_interruption()

    with pytest.raises(ValueError, match="fails"):
        map_tasks(one, ["goes on", "fails", *range(20)], 2)
    assert set(began) == {"goes on", "fails"}


def test_threads_of_a_map_are_asked_by_the_check_of_their_caller_alone():
    asked, other = Asked(), Asked(1)

    def apart():
        with interrupt_by(other), pytest.raises(Stop):
            check_interruption()

    thread = threading.Thread(target=apart)
    with interrupt_by(asked):
        thread.start()
        map_tasks(lambda task: check_interruption(), range(10), 2)
        thread.join(SECONDS)
    check_interruption()
    assert (asked.number, other.number) == (10, 1)
