"""Whether a record keeps its promise, against simulations compared sample by sample."""

import numpy as np
import pytest

from mechid.designs.criterion import sizes
from mechid.designs.information import informations
from mechid.designs.planned_record import PlannedRecord
from mechid.designs.settings import DESIGN
from mechid.designs.trust import departing_share
from mechid.identification.output_error.space import SearchSpace
from mechid.simulation.simulator import Simulator, simulate_run
from paper import constant
from synthetic import COMMANDS, truth

RECORDS = [
    PlannedRecord(name="full_46", command=COMMANDS["full_46"], duration_s=0.5),
    PlannedRecord(name="micro_92", command=COMMANDS["micro_92"], duration_s=0.5),
    PlannedRecord(name="full_45", command=constant(45.0, start_angle_deg=0.0), duration_s=1.0),
]


def torque(space, record, q):
    """Return the torque at a point, offset and drift removed, (n,) N m."""
    simulator = Simulator(space.mechanism.plant, record.command, record.base, capacity=space.size)
    y = simulate_run(simulator.run(space.kernel(q))).torque
    x = np.arange(y.size)
    return y - np.polyval(np.polyfit(x, y, 1), x)


@pytest.mark.parametrize("scale", [1.0, 1e-4], ids=["as a test leaves it", "a hundred times as far"])
def test_a_record_departs_where_its_cost_is_not_the_quadratic(scale):
    """Truth: the draws made again by the definition, both torques simulated whole, least squares by polyfit."""
    space = SearchSpace(truth())
    q = space.start
    information = informations(space, RECORDS, q[None])
    reference = scale * information.sum(axis=1)
    found = departing_share(space, RECORDS, q[None], information, reference, seed=5)
    assert np.all((found >= 0.0) & (found <= 1.0))
    assert np.all(np.isin(np.round(found * DESIGN.draws), range(DESIGN.draws + 1)))
    for k, record in enumerate(RECORDS):
        off = [_departs(space, record, q, x, information[0, k]) for x in _draws(space, q, reference[0], 5)]
        assert found[k] == np.mean(off), record.name


def _draws(space, q, reference, seed):
    """Return the draws of the definition: normal with the reference's inverse, no axis beyond `DESIGN.farthest`."""
    size = sizes(space, q[None])
    values, vectors = np.linalg.eigh(reference * np.outer(size, size))
    length = np.minimum(values**-0.5, DESIGN.farthest)
    normal = np.random.default_rng((seed, 3)).standard_normal((space.size, DESIGN.draws))
    return np.clip(q + (size[:, None] * vectors * length @ normal).T, space.lower, space.upper)


def _departs(space, record, q, x, information):
    cost = np.sum(((torque(space, record, x) - torque(space, record, q)) / record.sigma) ** 2)
    return abs(cost - (x - q) @ information @ (x - q)) > 1.0


def test_far_draws_depart_and_near_ones_do_not():
    """Truth: a quadratic holds near its middle; stick and slip fall otherwise a percent away."""
    space = SearchSpace(truth())
    q = space.start[None]
    information = informations(space, RECORDS[:2], q)
    near = departing_share(space, RECORDS[:2], q, information, 1e4 * information.sum(axis=1))
    far = departing_share(space, RECORDS[:2], q, information, 1e-8 * information.sum(axis=1))
    assert np.all(near == 0.0)
    assert far[0] > 0.5
