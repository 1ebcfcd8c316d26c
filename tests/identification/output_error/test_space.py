"""Search coordinates: round trips, derivatives against differences, bounds, the disc of a detent."""

import math

import numpy as np
import pytest

from mechid.identification.output_error.space import SearchSpace
from synthetic import bounded, truth

FIRST, SECOND = "stepper.detent.0.amplitude", "stepper.detent.1.amplitude"
PHASE = "stepper.detent.1.phase_deg"
STATIC, COULOMB = "friction.static", "friction.coulomb"

SPACES = {
    "cartesian": SearchSpace(truth()),
    "polar": SearchSpace(truth(), frozenset({FIRST, SECOND})),
    "one polar": SearchSpace(truth(), frozenset({SECOND})),
    "narrow phase": SearchSpace(bounded(truth(), PHASE, min=-170.0, max=-20.0)),
    "amplitude off zero": SearchSpace(bounded(truth(), SECOND, min=0.001)),
    "static alone": SearchSpace(truth().with_free((STATIC,))),
    "coulomb alone": SearchSpace(truth().with_free((COULOMB,))),
    "phase alone": SearchSpace(truth().with_free((PHASE,))),
}


@pytest.fixture(params=SPACES, ids=lambda name: name.replace(" ", "_"))
def space(request):
    return SPACES[request.param]


def inner_points(space, count, seed):
    """Return points inside the bounds, (count, n): an angle within a turn, static friction below its limit."""
    rng = np.random.default_rng(seed)
    turning = np.array([space.is_turning(c) for c in space.coordinates])
    lower, upper = np.where(turning, -179.0, space.lower), np.where(turning, 179.0, space.upper)
    q = lower + rng.uniform(0.05, 0.45, (count, space.size)) * (upper - lower)
    for j, c in enumerate(space.coordinates):
        if c.kind == "cosine":  # inside the disc, anywhere around it
            radius, angle = c.upper * rng.uniform(0.1, 0.95, count), rng.uniform(-np.pi, np.pi, count)
            q[:, j], q[:, j + 1] = radius * np.cos(angle), radius * np.sin(angle)
    return q


def slopes(function, q, scale, share=1e-4):
    """Return d(function)/dq by central differences of fourth order, steps a share of `scale`."""
    columns = []
    for j, unit in enumerate(scale):
        h = np.zeros_like(q)
        h[j] = share * unit
        near, far = (function(q + k * h) - function(q - k * h) for k in (1, 2))
        columns.append((8.0 * near - far) / (12.0 * h[j]))
    return np.column_stack(columns)


def scale_of(space):
    """Return a length for each coordinate over which its maps bend: a log's is 1, all others' a part of its range."""
    span = np.minimum(space.upper - space.lower, 100.0)
    return np.array([1.0 if c.kind == "log" else 0.1 * w for c, w in zip(space.coordinates, span, strict=True)])


def test_the_values_of_the_file_come_back(space):
    """Truth: the values that went in, an angle on the circle."""
    known = {q.name: q.value for q in space.mechanism.parameters.values()}
    for name, value in space.values(space.from_values(known)).items():
        assert value == pytest.approx(known[name], rel=1e-13), name


def test_coordinates_come_back(space):
    """Truth: the coordinates that went in, wherever they stand."""
    for q in inner_points(space, 50, seed=1):
        values = {**{p.name: p.value for p in space.mechanism.parameters.values()}, **space.values(q)}
        np.testing.assert_allclose(space.from_values(values), q, rtol=1e-11, atol=1e-14)


def test_the_kernel_moves_as_its_jacobian_says(space):
    """Truth: differences of the kernel's parameters."""
    for q in inner_points(space, 10, seed=2):
        differences = slopes(space.kernel, q, scale_of(space))
        size = np.abs(differences).max(axis=0)
        assert np.all(size > 0.0)
        np.testing.assert_allclose(space.kernel_jacobian(q) / size, differences / size, rtol=0.0, atol=1e-8)


def test_the_values_move_as_their_jacobian_says(space):
    """Truth: differences of the values in the file's units; a phase's are in degrees, unwrapped."""
    names, _ = space.value_jacobian(space.start)
    for q in inner_points(space, 10, seed=3):
        here = space.values(q)

        def values(x, here=here):
            moved = space.values(x)
            steps = {n: moved[n] - here[n] for n in names}
            return np.array([math.remainder(d, 360.0) if n.endswith("_deg") else d for n, d in steps.items()])

        differences = slopes(values, q, scale_of(space), share=1e-5)
        size = np.abs(differences).max(axis=0)
        np.testing.assert_allclose(space.value_jacobian(q)[1] / size, differences / size, rtol=0.0, atol=1e-7)


def test_no_point_within_the_bounds_leaves_those_of_the_file(space):
    """Truth: min and max of every parameter, static never below Coulomb friction; of detents see the disc."""
    rng = np.random.default_rng(4)
    corners = rng.integers(0, 2, (200, space.size)).astype(float)
    inside = rng.uniform(0.0, 1.0, (200, space.size))
    in_disc = {c.name for c in space.coordinates if c.kind == "cosine"}
    for unit in (*corners, *inside):
        values = space.values(space.lower + unit * (space.upper - space.lower))
        for name, value in values.items():
            p = space.mechanism.parameters[name]
            if not p.is_periodic and name not in in_disc:
                assert p.min <= value <= p.max, name
        static = values.get(STATIC, space.mechanism.value(STATIC))
        assert static >= values.get(COULOMB, space.mechanism.value(COULOMB)) - 1e-15


def test_what_lies_outside_is_brought_to_the_nearest_bound():
    """Truth: the bounds of the file, 300 and 5000 N m/rad, in logarithms."""
    space = SearchSpace(truth().with_free(("gear.stiffness",)))
    assert space.values(space.clip(np.array([math.log(10.0)]))) == pytest.approx({"gear.stiffness": 300.0}, rel=1e-14)
    assert space.from_values({"gear.stiffness": 1e9})[0] == math.log(5000.0)


def test_the_limit_of_an_amplitude_is_a_disc():
    """Truth: hypot(K cos, K sin) against the file's maximum of 0.1 N m, in a box whose corners lie beyond."""
    space = SPACES["cartesian"]
    at = {kind: i for i, c in enumerate(space.coordinates) if c.name == SECOND for kind in [c.kind]}
    for cosine, sine in ((0.07, 0.07), (0.08, 0.07), (-0.099, 0.0), (-0.08, -0.07), (0.0, 0.1)):
        q = space.start.copy()
        q[at["cosine"]], q[at["sine"]] = cosine, sine
        assert space.outside_disc(q) == (frozenset({SECOND}) if math.hypot(cosine, sine) > 0.1 else frozenset())


def test_the_phase_of_a_detent_that_starts_at_zero_is_not_dead():
    """Truth: K cos phi and K sin phi are the kernel's own a and b, so their derivatives are 1, at K = 0 too."""
    space = SearchSpace(truth({SECOND: 0.0}))
    order = [str(s) for s in space.mechanism.plant.parameters]
    at = {c.kind: j for j, c in enumerate(space.coordinates) if c.name == SECOND}
    J = space.kernel_jacobian(space.start)
    assert J[order.index("a_2"), at["cosine"]] == 1.0
    assert J[order.index("b_2"), at["sine"]] == 1.0
    assert np.all(np.isfinite(space.value_jacobian(space.start)[1]))


def test_static_friction_follows_coulomb_until_its_limit():
    """Truth: static = Coulomb + excess up to the file's 0.1 N m, from there on neither moves it."""
    space = SPACES["cartesian"]
    names, _ = space.value_jacobian(space.start)
    at = {c.name: j for j, c in enumerate(space.coordinates)}
    q = space.start.copy()
    for coulomb, excess, slope in ((0.02, 0.03, 1.0), (0.06, 0.05, 0.0)):
        q[at[COULOMB]], q[at[STATIC]] = coulomb, excess
        assert space.values(q)[STATIC] == pytest.approx(min(coulomb + excess, 0.1), rel=1e-14)
        row = space.value_jacobian(q)[1][names.index(STATIC)]
        assert (row[at[COULOMB]], row[at[STATIC]]) == (slope, slope)


def test_parameters_that_are_tied_move_with_their_master():
    """Truth: the file leaves k_v out, so k_v = k_m in SI units, and so is its derivative to log k_m."""
    space = SearchSpace(truth().with_free(("stepper.torque_constant",)))
    order = [str(s) for s in space.mechanism.plant.parameters]
    q = np.array([math.log(0.3)])
    for vector in (space.kernel(q), space.kernel_jacobian(q)[:, 0]):
        assert vector[order.index("k_m")] == vector[order.index("k_v")] == pytest.approx(0.3, rel=1e-14)
