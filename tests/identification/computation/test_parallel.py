"""The one map over tasks, in threads and elsewhere. Truth: the built-in map."""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from multiprocessing import get_context

import pytest

import chores
from mechid.errors import FitError
from mechid.identification.computation.parallel import map_tasks
from mechid.identification.computation.workforce import working_on

SPAWN = get_context("spawn")


@pytest.fixture(scope="module")
def pool():
    """Return two processes that share nothing with this one."""
    with ProcessPoolExecutor(2, mp_context=SPAWN) as executor:
        yield executor


def test_results_come_in_the_order_of_the_tasks(pool):
    """Truth: the built-in map; the first task ends last."""
    with working_on(pool):
        assert map_tasks(chores.slow_first, range(30), 1) == list(range(30))
        assert map_tasks(partial(chores.squared, 3), range(200), 1) == [(n + 3) ** 2 for n in range(200)]
        assert map_tasks(partial(chores.squared, 3), [], 1) == []


def test_each_task_is_told_of_once_with_its_result(pool):
    told = {}
    with working_on(pool):
        map_tasks(
            partial(chores.squared, 0), range(50), 1, lambda done: told.update({i: result for i, result, _ in done})
        )
    assert told == {i: i**2 for i in range(50)}


def test_what_a_task_raises_is_raised_here(pool):
    """Of its own kind, with the worker's traceback in a note; the results before it are told of."""
    told = []
    with working_on(pool), pytest.raises(FitError, match="task 2") as caught:
        map_tasks(partial(chores.failing, 2), range(3), 1, lambda done: told.extend(i for i, _, _ in done))
    assert "in failing" in caught.value.__notes__[0]
    assert set(told) <= {0, 1}


def test_work_within_a_task_stays_on_its_core():
    """Truth: a map within a map, by an executor of threads, which would wait for itself for ever."""
    with ThreadPoolExecutor(1) as threads, working_on(threads):
        assert map_tasks(_mapped_within, range(2), 1) == [[0, 1, 4], [1, 4, 9]]


def _mapped_within(shift):
    return map_tasks(partial(chores.squared, shift), range(3), 4)
