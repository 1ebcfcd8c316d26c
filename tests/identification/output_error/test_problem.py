"""The reduced triangle against the dense problem: whole residual and Jacobian, projected by least squares."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from mechid.command import Timing
from mechid.identification.output_error.problem import Problem, transfer_coordinates, transfer_values
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from mechid.signal.autoregression import Autoregression
from mechid.simulation.interruption import interrupt_by
from mechid.simulation.simulator import Simulator, simulate_run
from paper import SENSITIVE
from synthetic import COMMANDS, displaced, measured, measuring, record, truth, with_leading

FREE = {
    "stepper.coil_resistance": 1.03,
    "stepper.detent.1.amplitude": 1.1,
    "stepper.detent.1.phase_deg": 1.05,
    "friction.static": 1.2,
    "friction.coulomb": 0.9,
    "gear.stiffness": 0.98,
    "housing.frequency": 1.01,
}
SECONDS = 0.25
"""Of each record: 2501 samples, so more than two of the simulator's blocks."""
DELAY = {"value": 3.3e-4, "min": -2e-3, "max": 2e-3}
WINDOWS = {"full_46": (0, 2501), "micro_46": (1000, 2311), "micro_92": (37, 1061)}
"""All of it, within blocks, and across the boundary of one."""


@pytest.fixture(scope="module")
def problem():
    """Return three records with offset and drift, offset alone, and neither; the first has a time offset."""
    rng = np.random.default_rng(11)
    made = {name: measured(truth(), COMMANDS[name], rng, seconds=SECONDS) for name in WINDOWS}
    records = (
        record("full_46", made["full_46"], COMMANDS["full_46"], time_offset=DELAY),
        record("micro_46", made["micro_46"], COMMANDS["micro_46"], drift=False),
        record("micro_92", made["micro_92"], COMMANDS["micro_92"], offset=False),
    )
    space = SearchSpace(displaced(truth(), FREE))
    return Problem(space, tuple(map(target_of, records)))


def dense(problem, target, q, window):
    """Return r, (n,), and J, (n, size), in sigmas: one lane per kernel parameter, chained by hand, then lstsq."""
    space, own = problem.space, q[: problem.space.size]
    chain = space.kernel_jacobian(own)
    moved = np.flatnonzero(np.any(chain != 0.0, axis=1))
    lanes = [(int(i),) for i in moved]
    simulator = Simulator(space.mechanism.plant, target.command, target.base, lanes, DELAY["max"], len(SENSITIVE))
    offset = problem.coordinates.timing(target, q).offset_s
    run = simulate_run(simulator.run(space.kernel(own), timing=Timing(offset), substeps=problem.substeps))
    J = np.zeros((target.samples, problem.size))
    J[:, : space.size] = run.jacobian["torque"] @ chain[moved]
    delay = f"record.{target.name}.time_offset_s"
    if delay in problem.coordinates.names:
        J[:, problem.coordinates.names.index(delay)] = -run.rate["torque"]
    rows = np.column_stack([run.torque - target.leading.measured, J])[slice(*window)] / target.leading.sigma
    phi = np.vander(np.arange(len(rows), dtype=float), target.leading.linear)
    rows = rows - phi @ np.linalg.lstsq(phi, rows, rcond=None)[0] if target.leading.linear else rows
    return rows[:, 0], rows[:, 1:]


def assert_same(triangle, r, J):
    """Compare cost, gradient and Gauss-Newton matrix, each column in its own size."""
    size = np.linalg.norm(J, axis=0)
    size[size == 0.0] = 1.0
    assert triangle.cost == pytest.approx(r @ r, rel=1e-10)
    assert triangle.samples == r.size
    reduced, scaled = triangle.jacobian / size, J / size
    np.testing.assert_allclose(reduced.T @ triangle.fun, scaled.T @ r, rtol=1e-9, atol=1e-9 * np.linalg.norm(r))
    np.testing.assert_allclose(reduced.T @ reduced, scaled.T @ scaled, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", WINDOWS)
@pytest.mark.parametrize("window", [None, (0, 1), (5, 300)])
def test_one_record_reduces_to_its_dense_problem(problem, name, window):
    """Truth: numpy on all rows; also a window of a single sample, of which nothing is left."""
    target = next(t for t in problem.targets if t.name == name)
    window = window or WINDOWS[name]
    r, J = dense(problem, target, problem.start, window)
    if window == (0, 1) and target.leading.linear:
        assert problem.triangle(target, problem.start, window).norm <= 1e-9
        return
    assert_same(problem.triangle(target, problem.start, window), r, J)
    assert problem.norm(target, problem.start, window) == pytest.approx(np.linalg.norm(r), rel=1e-10)


@pytest.mark.parametrize("workers", [1, 3])
def test_records_join_to_the_stacked_dense_problem(problem, workers):
    """Truth: the rows of all records in their windows below one another; a record without window does not count."""
    problem = replace(problem, workers=workers)
    for windows in (WINDOWS, {name: WINDOWS[name] for name in ("micro_46", "micro_92")}):
        used = [t for t in problem.targets if t.name in windows]
        parts = [dense(problem, t, problem.start, windows[t.name]) for t in used]
        r, J = np.concatenate([p[0] for p in parts]), np.vstack([p[1] for p in parts])
        assert_same(problem.joint(problem.start, windows), r, J)


def test_the_gradient_is_that_of_the_cost(problem):
    """Truth: differences of the cost, of fourth order, over the first 30 ms."""
    windows = dict.fromkeys(WINDOWS, (0, 300))

    def cost(q):
        return sum(norm**2 for norm in problem.norms(q, windows))

    triangle = problem.joint(problem.start, windows)
    gradient = 2.0 * triangle.jacobian.T @ triangle.fun
    for j in range(problem.size):
        size = np.linalg.norm(triangle.jacobian[:, j])
        h = np.zeros(problem.size)
        h[j] = 1e-1 / size  # a tenth of a sigma
        near, far = (cost(problem.start + k * h) - cost(problem.start - k * h) for k in (1, 2))
        assert gradient[j] / size == pytest.approx((8.0 * near - far) / (12.0 * h[j]) / size, rel=1e-5, abs=1e-3)


MASKED = np.concatenate([[3, 4], np.arange(400, 460), [1023, 1024], np.arange(1500, 1505), [2480]])
"""A gap at the beginning, a long one, one across two blocks of the simulator, a short one, a single sample."""


@pytest.mark.parametrize("window", [(0, 2501), (402, 1502)])
@pytest.mark.parametrize("taps", [(1.0,), (1.0, -0.7, 0.2, 0.1)])
def test_samples_that_do_not_count_are_not_there(problem, window, taps):
    """Truth: the dense problem of each stretch between gaps filtered by itself, its first samples left out."""
    target = problem.targets[0]
    colour, order = Autoregression(np.array(taps), 3e-3), len(taps) - 1
    spoilt = target.leading.measured.copy()
    spoilt[MASKED] = 7.0
    masked = with_leading(target, measured=spoilt, rejected=MASKED, prefilter=colour if order else None, linear=0)
    r, J = dense(problem, with_leading(target, linear=0), problem.start, (0, target.samples))
    sigma = target.leading.sigma
    rows = np.column_stack([np.vander(np.arange(len(r), dtype=float), 2), r * sigma, J * sigma])
    counted = np.setdiff1d(np.arange(*window), MASKED)
    stretches = [rows[part] for part in np.split(counted, np.flatnonzero(np.diff(counted) > 1) + 1)]
    kept = np.vstack([lfilter(taps, [1.0], part, axis=0)[order:] for part in stretches])
    kept /= colour.sigma if order else sigma
    phi, rest = kept[:, :2], kept[:, 2:]
    rest = rest - phi @ np.linalg.lstsq(phi, rest, rcond=None)[0]
    triangle = problem.triangle(with_leading(masked, linear=2), problem.start, window)
    assert triangle.cost == pytest.approx(rest[:, 0] @ rest[:, 0], rel=1e-9)
    size = np.linalg.norm(rest[:, 1:], axis=0)
    size[size == 0.0] = 1.0
    reduced, scaled = triangle.jacobian / size, rest[:, 1:] / size
    np.testing.assert_allclose(reduced.T @ reduced, scaled.T @ scaled, rtol=1e-8, atol=1e-8)


def test_offset_and_drift_change_nothing(problem):
    """Truth: what is projected out has no effect; where nothing is projected out it has."""
    shifted = replace(
        problem, targets=tuple(measuring(t, t.leading.measured + 0.3 - 20.0 * t.base.times) for t in problem.targets)
    )
    before, after = problem.norms(problem.start, WINDOWS), shifted.norms(problem.start, WINDOWS)
    assert after[0] == pytest.approx(before[0], rel=1e-9)
    assert after[1] > 2.0 * before[1]
    assert after[2] > 2.0 * before[2]


def test_a_shorter_window_is_the_beginning_of_the_whole(problem):
    """Truth: causality, bit for bit: a run of the first samples is that of all, cut off."""
    for target in problem.targets:
        (whole,) = problem.model.predict(target, problem.start, target.samples)
        for stop in (1, 700, 1024, 1025, 2500):
            np.testing.assert_array_equal(problem.model.predict(target, problem.start, stop)[0], whole[:stop])


def test_a_detent_beyond_its_disc_goes_on_by_amplitude_and_phase(problem):
    """Truth: the kernel's parameters, the amplitude cut at its maximum of 0.1 N m and its phase kept."""
    q = problem.start.copy()
    at = {c.kind: j for j, c in enumerate(problem.space.coordinates) if c.kind in ("cosine", "sine")}
    q[at["cosine"]], q[at["sine"]] = 0.09, -0.09
    outside = problem.space.outside_disc(q[: problem.space.size])
    polar, moved = problem.to_polar(outside, q)
    values = polar.space.values(moved[: polar.space.size])
    assert values["stepper.detent.1.amplitude"] == 0.1
    assert values["stepper.detent.1.phase_deg"] == pytest.approx(-45.0, rel=1e-13)
    kinds = [c.kind for c in polar.space.coordinates]
    assert "cosine" not in kinds
    others = {c.name for c in polar.space.coordinates} - {"stepper.detent.1.amplitude", "stepper.detent.1.phase_deg"}
    before = problem.space.values(q[: problem.space.size])
    assert {n: values[n] for n in others} == pytest.approx({n: before[n] for n in others}, rel=1e-13)
    assert moved[-1] == DELAY["value"]


def test_what_stands_on_a_bound_is_known():
    """Truth: the bounds of the file; a detent's is the circle of its amplitude, an angle's there is none."""
    mechanism = truth().with_free(tuple(FREE))
    rng = np.random.default_rng(3)
    target = target_of(
        record("full_46", measured(mechanism, COMMANDS["full_46"], rng, seconds=0.1), COMMANDS["full_46"])
    )
    problem = Problem(SearchSpace(mechanism), (target,))
    names = np.array(problem.coordinates.names)
    assert not problem.coordinates.on_bound(problem.start).any()
    cases = {
        "gear.stiffness": {"gear.stiffness": 5000.0},
        "stepper.coil_resistance": {"stepper.coil_resistance": 5.0},
        "stepper.detent.1.amplitude": {"stepper.detent.1.amplitude": 0.1},
        "friction.static": {"friction.static": 0.1},
        "friction.coulomb": {"friction.coulomb": 0.0},
    }
    known = {p.name: p.value for p in mechanism.parameters.values()}
    for name, moved in cases.items():
        q = problem.space.from_values({**known, **moved})
        assert set(names[problem.coordinates.on_bound(q)]) == {name}
    polar, q = problem.to_polar(frozenset({"stepper.detent.1.amplitude"}), problem.start)
    q = polar.space.from_values({**known, "stepper.detent.1.phase_deg": -180.0})
    assert not polar.coordinates.on_bound(q).any()


def test_a_triangle_is_kept_for_its_own_problem_point_and_window(problem):
    """Truth: the blocks of samples that are simulated: none where the last one is asked for again."""
    problem, asked = replace(problem), []
    target, q = problem.targets[1], problem.start
    with interrupt_by(lambda: asked.append(1)):
        kept = problem.triangle(target, q, (0, 300))
        once = len(asked)
        assert problem.triangle(target, q.copy(), (0, 300)) is kept
        assert len(asked) == once > 0
        louder = with_leading(target, sigma=2.0 * target.leading.sigma)
        for other in (problem, replace(problem, targets=(louder,))):
            assert other.triangle(louder, q, (0, 300)).norm == pytest.approx(0.5 * kept.norm, rel=1e-12)
        assert len(asked) == 3 * once
        assert problem.triangle(target, q, (0, 301)).samples == 301


def test_coordinates_are_transferred_to_the_last_bit_and_values_are_not(problem):
    """Truth: the point itself, in a problem of the same mechanism; by values it comes back within rounding."""
    other, values_differ, at = replace(problem), False, problem.coordinates
    for row in np.random.default_rng(3).uniform(at.lower, at.upper, (20, problem.size)):
        q = at.point(at.values(row))  # within bounds that depend on one another
        np.testing.assert_array_equal(transfer_coordinates(problem, q, other), q)
        by_values = transfer_values(problem, q, other)
        np.testing.assert_allclose(by_values, q, rtol=1e-12, atol=1e-12)
        values_differ |= bool(np.any(by_values != q))
    assert values_differ, "else one function would do"


def test_a_point_of_some_records_is_joined_with_what_the_others_have(problem):
    """Truth: the coordinates of the mechanism from the part, the time offset that it does not have from elsewhere."""
    part = problem.restrict_to(["micro_46", "micro_92"])
    q, at = part.start + 0.01, problem.start + 0.02 * problem.coordinates.span
    joined = problem.point_from(part, q)
    np.testing.assert_array_equal(problem.coordinates.of_mechanism(joined), q)
    np.testing.assert_array_equal(problem.coordinates.of_records(joined), problem.coordinates.of_records(problem.start))
    joined = problem.point_from(part, q, at)
    np.testing.assert_array_equal(problem.coordinates.of_records(joined), problem.coordinates.of_records(at))
    np.testing.assert_array_equal(part.point_from(problem, joined), q)
