"""What is remembered of points that all records ask for."""

import pickle

import numpy as np

from complete_fits import CASES
from mechid.identification.identify import make_problem
from mechid.identification.output_error.point_cache import PointCache
from mechid.identification.output_error.settings import PROBLEM


def test_a_point_is_worked_out_once():
    asked = []

    def work(q):
        asked.append(q.tolist())
        return 2.0 * q

    latest, points = PointCache(), [np.full(2, float(k)) for k in range(PROBLEM.results_kept + 1)]
    for q in (*points[:2], *points[:2]):
        np.testing.assert_array_equal(latest.of("values", q, work), 2.0 * q)
    np.testing.assert_array_equal(latest.of("directions", points[0], lambda q: 3.0 * q), 3.0 * points[0])
    assert asked == [[0.0, 0.0], [1.0, 1.0]]
    for q in points:
        latest.of("values", q, work)
    assert len(latest) <= PROBLEM.results_kept


def test_it_is_not_sent_along():
    latest = PointCache()
    latest.of("values", np.zeros(2), np.copy)
    assert not pickle.loads(pickle.dumps(latest))


def test_what_is_remembered_is_what_would_be_worked_out(tmp_path):
    """Truth: the search space, which remembers nothing; also of a record that has a value of its own."""
    problem = make_problem(CASES["direct_torque_drive"].campaign(tmp_path), 1)
    at, target = problem.coordinates, problem.targets[0]
    for q in (problem.start, np.nextafter(problem.start, np.inf), problem.start):
        np.testing.assert_array_equal(at.kernel(target, q), at.space.kernel(q))
        np.testing.assert_array_equal(at.directions(target, q), at.space.kernel_jacobian(q))
