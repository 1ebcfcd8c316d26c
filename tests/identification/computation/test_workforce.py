"""Work lent out: processes, and executors that are odd. Truth: the same map in threads of this process."""

import pickle
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from itertools import count
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

import chores
import synthetic
from finished import optimum
from mechid.campaign import load_mechanism
from mechid.errors import WorkersError
from mechid.identification.computation import worker
from mechid.identification.computation.journal import Journal
from mechid.identification.computation.parallel import map_tasks
from mechid.identification.computation.settings import WORK
from mechid.identification.computation.workforce import working_on
from mechid.identification.identify import identify, make_problem
from mechid.identification.readings import agreement
from mechid.identification.readings.agreement import _first_look, start_points
from mechid.identification.refit.bootstrap import bootstrap
from mechid.identification.refit.profile import profiles
from mechid.identification.search.settings import SEARCH
from mechid.identification.uncertainty.draws import examine_draws
from synthetic import displaced

DRAWS = 6
SPAWN = get_context("spawn")


@pytest.fixture(scope="module")
def pool():
    """Return two processes that share nothing with this one."""
    with ProcessPoolExecutor(2, mp_context=SPAWN) as executor:
        yield executor


@pytest.fixture(scope="module")
def housing():
    return optimum("housing.gain", "housing.frequency")


def test_a_bootstrap_is_the_same_to_the_last_bit(pool, housing):
    there = bootstrap(housing, DRAWS, executor=pool)
    assert repr(there.draws) == repr(bootstrap(housing, DRAWS, workers=1).draws)


def test_a_profile_is_the_same_to_the_last_bit(pool, housing):
    """Its points follow one another; both sides go on at once."""
    there, here = profiles(housing, ["housing.gain"], executor=pool), profiles(housing, ["housing.gain"])
    for found, own in zip(there, here, strict=True):
        assert [(p.value, p.rise, p.q.tobytes()) for p in found.points] == [
            (p.value, p.rise, p.q.tobytes()) for p in own.points
        ]
        assert (found.interval, found.ends) == (own.interval, own.ends)


def test_draws_of_the_covariance_are_the_same_to_the_last_bit(pool, housing):
    covariance = 4.0 * np.linalg.inv(housing.triangle.jacobian.T @ housing.triangle.jacobian)
    asked = (housing.problem, housing.q, housing.windows, covariance, 1)
    with working_on(pool):
        there = examine_draws(*asked).departures
    assert there == examine_draws(*asked).departures


@pytest.mark.slow
def test_an_identification_is_the_same_to_the_last_bit(pool):
    """From the catalogue to the standard errors: multi-start, refined starts, first sight, draws."""
    start = displaced(synthetic.truth(), {"gear.stiffness": 1.1, "gear.damping": 0.8})
    campaign = synthetic.bench(start, synthetic.truth(), "full_46", "micro_92", seed=5, seconds=0.3)
    with working_on(pool):
        there = identify(campaign)
    here = identify(campaign, workers=1)
    assert there.outcome is here.outcome
    for name, p in here.parameters.items():
        assert (there.parameters[name].value, there.parameters[name].std_error) == (p.value, p.std_error), name


def test_a_block_of_ones_own_goes_along(pool):
    """Truth: the kernel's hash here; the worker has never seen the file of the block."""
    mechanism = load_mechanism(Path(__file__).parents[3] / "examples" / "own_block" / "mechanism.toml")
    with working_on(pool):
        assert map_tasks(chores.hash_of_kernel, [mechanism], 1) == [chores.hash_of_kernel(mechanism)]


def test_a_problem_goes_to_a_worker_once():
    """Truth: the digest alone, but for the first batch of the one worker that there is."""
    recorded = chores.Recorded(1)
    heavy = np.zeros(100_000)
    with working_on(recorded):
        function = partial(chores.squared, heavy)
        for first in range(3):
            map_tasks(function, range(first, first + 40), 1)
    carried = [function for _, _, function, _ in recorded.calls if function is not None]
    assert len(recorded.calls) > 2 * WORK.ahead
    assert len(carried) == 1
    assert len(carried[0]) > heavy.nbytes
    assert all(len(tasks) < 1000 for *_, tasks in recorded.calls)


def test_batches_take_a_second(monkeypatch):
    """Truth: tasks of 10 ms by the clock that the worker reads, so a hundred to a batch once that is known."""
    now = count(step=0.01)
    monkeypatch.setattr(worker.time, "perf_counter", lambda: next(now))
    recorded = chores.Recorded(1)
    with working_on(recorded):
        map_tasks(partial(chores.squared, 0), range(1000), 1)
    sizes = [len(pickle.loads(tasks)) for *_, tasks in recorded.calls]
    assert sum(sizes) == 1000
    assert sizes[: 2 * WORK.ahead] == [1] * WORK.ahead + sizes[WORK.ahead : 2 * WORK.ahead]
    assert all(size in (100, 101) for size in sizes[WORK.ahead : -1])


def test_a_process_that_dies_is_told_and_its_journal_goes_on(tmp_path):
    """Truth: what had ended before is in the journal, and is not worked out again."""
    path, before = tmp_path / "journal.jsonl", list(range(4))
    with ProcessPoolExecutor(1, mp_context=SPAWN) as doomed, working_on(doomed):
        journal = Journal.open(path, {})
        assert journal.map_tasks("square", partial(chores.squared, 0), before, 1) == [0, 1, 4, 9]
        with pytest.raises(WorkersError, match=r"the workers are lost .* continue with --resume, with or without them"):
            journal.map_tasks("square", chores.fatal, [4], 1)
    resumed = Journal.open(path, {}, resume=True)
    asked = []
    assert resumed.map_tasks("square", lambda n: asked.append(n) or n**2, [*before, 4], 1) == [0, 1, 4, 9, 16]
    assert asked == [4]


def test_the_first_look_of_a_multi_start_goes_out_whole(pool, monkeypatch):
    """Truth: the costs of the same points here."""
    monkeypatch.setattr(agreement, "SEARCH", replace(SEARCH, points=128))
    campaign = synthetic.bench(synthetic.truth(), synthetic.truth(), "full_46", seed=5, seconds=0.1)
    problem = make_problem(campaign, 1)
    points = start_points(problem, 3)
    with working_on(pool):
        there = _first_look(problem, points)
    here = _first_look(problem, points)
    assert there.shape == (len(points), 1) == (128, 1)
    assert there.tobytes() == here.tobytes()
