"""Counts of work. Truth: numbers by hand, and the samples of runs."""

import math
from threading import Thread

import numpy as np
import pytest

from mechid.identification.computation.journal import Journal
from mechid.identification.computation.parallel import in_threads, map_tasks
from mechid.identification.identify import make_problem
from mechid.simulation.work import WorkSpentError, count, suspend_counting, work_counter, work_of_run
from synthetic import bench, truth


@pytest.fixture(scope="module")
def problem():
    return make_problem(bench(truth(), truth(), "full_46", seed=5, seconds=0.1), 1)


def test_work_counts_in_all_counts_around_it():
    with work_counter() as outer:
        count(2)
        with work_counter() as inner:
            count(3)
        with suspend_counting():
            count(100)
    count(1000)
    assert (outer.done, inner.done) == (5, 3)


def test_a_limit_ends_the_work_and_whatever_is_begun_after_it():
    with work_counter(limit=10) as work:
        count(10)
        for _ in range(2):
            with pytest.raises(WorkSpentError):
                count(1)
        with suspend_counting():
            count(1)
        work.limit = math.inf
        count(1)
    assert work.done == 13
    with work_counter(limit=1), pytest.raises(WorkSpentError), work_counter():
        count(2)


def test_threads_count_where_they_were_begun():
    with work_counter() as work:
        in_threads(count, range(1, 5), 2)
        other = Thread(target=count, args=(100,))
        other.start()
        other.join()
    assert work.done == 10


def test_runs_count_their_samples(problem):
    """Truth: samples, parameters and derivatives by hand; the triangle that is kept counts again."""
    samples, parameters = problem.targets[0].samples, len(problem.space.mechanism.plant.parameters)
    with work_counter() as plain:
        problem.norms(problem.start, problem.whole_windows())
    assert plain.done == samples * parameters
    q = problem.start * (1.0 + 1e-9)
    with work_counter() as first:
        problem.joint(q, problem.whole_windows())
    assert first.done == work_of_run(samples, parameters, problem.coordinates.lanes)
    with work_counter() as again:
        problem.joint(q, problem.whole_windows())
    assert again.done == first.done


def test_what_a_journal_holds_counts_as_it_did(tmp_path):
    """Truth: the first run, whose steps were worked out."""

    def run(resume):
        journal = Journal.open(tmp_path / "journal.jsonl", {"a": "b"}, resume=resume)
        done = []
        with work_counter() as work:
            journal.step("one", [1], lambda: count(3))
            done.append(work.done)
            journal.map_tasks("many", lambda task: count(int(task)), [1, 2, 4], 1)
            done.append(work.done)
            map_tasks(count, [10], 1)
        return [*done, work.done]

    assert run(resume=False) == run(resume=True) == [3, 10, 20]


def test_work_elsewhere_counts_here():
    class Elsewhere:
        def map_tasks(self, function, tasks, ended):
            found = []
            thread = Thread(target=lambda: found.extend(map(function, tasks)))
            thread.start()
            thread.join()
            ended([(n, result, 0.0) for n, result in enumerate(found)])
            return found

    from mechid.identification.computation.parallel import mapping_through

    ended = []
    with work_counter() as work, mapping_through(Elsewhere()):
        assert map_tasks(count, [1, 2], 1, ended.extend) == [None, None]
    assert work.done == 3
    assert ended == [(0, None, 0.0), (1, None, 0.0)]


def test_the_work_of_a_run_grows_with_its_derivatives():
    assert work_of_run(100, 20, 0) == 2000
    np.testing.assert_array_equal([work_of_run(100, 20, m) for m in (6, 12)], [4000, 6000])
