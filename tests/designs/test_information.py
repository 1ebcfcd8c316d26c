"""The information of a record against a dense least-squares problem made by hand."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.designs.information import informations, prior_points, range_information
from mechid.designs.planned_record import PlannedRecord
from mechid.identification.output_error.space import SearchSpace
from mechid.simulation.simulator import Simulator, TimeBase
from paper import constant
from synthetic import truth

FREE = ("stepper.torque_constant", "gear.stiffness", "friction.viscous")


def planned(**changes):
    return PlannedRecord(**{"name": "full_46", "command": constant(46.0), "duration_s": 0.2, **changes})


def dense(space, record):
    """Return the Jacobian, (samples, n), and the time derivative, by one run over the whole record."""
    directions = space.kernel_jacobian(space.start)
    base = TimeBase(record.sample_rate_hz, record.base.samples)
    simulator = Simulator(space.mechanism.plant, record.command, base, capacity=space.size)
    J, rate = [], []
    for block in simulator.run(space.kernel(space.start), directions=directions).blocks():
        J.append(block.jacobian[:, 0, : space.size].copy())
        rate.append(block.rate[:, 0].copy())
    return np.vstack(J), np.concatenate(rate)


@pytest.mark.parametrize(("linear", "offset"), [(2, None), (0, None), (2, (0.0, -0.001, 0.001))])
def test_offset_drift_and_time_offset_are_projected_out(linear, offset):
    """Truth: J^T P J / sigma^2 with P the projection across what is not of interest, by numpy's QR."""
    space = SearchSpace(truth().with_free(FREE))
    record = planned(linear=linear, time_offset=offset, sigma=0.003)
    (found,) = informations(space, [record], space.start[None])[:, 0]
    J, rate = dense(space, record)
    columns = [np.ones(len(J)), np.linspace(-1.0, 1.0, len(J))][:linear] + ([-rate] if offset else [])
    if columns:
        Q, _ = np.linalg.qr(np.column_stack(columns))
        J = J - Q @ (Q.T @ J)
    np.testing.assert_allclose(found, J.T @ J / 0.003**2, rtol=1e-6, atol=1e-9 * np.abs(found).max())


def test_a_record_that_cannot_be_simulated_tells_nothing():
    """Truth: a gear stiffer than the time step can follow diverges; zero is no information."""
    wild = truth({"gear.stiffness": 5000.0, "gear.damping": 5.0, "friction.viscous": 0.05}).with_free(FREE)
    space = SearchSpace(wild)
    coarse = planned(sample_rate_hz=100.0, duration_s=2.0)
    assert np.all(informations(space, [coarse], space.start[None]) == 0.0)


def test_prior_points_are_within_the_bounds_and_begin_with_the_file():
    """Truth: the bounds of the mechanism file, and its values."""
    space = SearchSpace(truth())
    points = prior_points(space, 12, seed=4)
    assert points.shape == (12, space.size)
    np.testing.assert_array_equal(points[0], space.start)
    assert np.all(points >= space.lower)
    assert np.all(points <= space.upper)
    np.testing.assert_array_equal(points, prior_points(space, 12, seed=4))


def test_a_prior_draws_the_points_together_and_tells_beforehand():
    """Truth: a tenth of the value as sigma: the points scatter by that, and the information is 1 / sigma^2 in logs."""
    mechanism = truth().with_free(("gear.stiffness",))
    q = mechanism.parameters["gear.stiffness"]
    known = mechanism.with_parameters({q.name: replace(q, sigma=0.1 * q.value)})
    points = np.exp(prior_points(SearchSpace(known), 400, seed=0)[:, 0]) / q.value
    assert np.std(points) == pytest.approx(0.1, rel=0.1)
    plain, told = range_information(SearchSpace(mechanism)), range_information(SearchSpace(known))
    assert told[0, 0] - plain[0, 0] == pytest.approx(100.0)
