"""Draws brought to their optima along one derivative. Truth: the solver, which works out each one's own."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.identification.identify import make_problem
from mechid.identification.refit import chord as module
from mechid.identification.refit.chord import chord_at, chord_optima
from mechid.identification.refit.settings import REFIT
from mechid.identification.search.settings import SEARCH
from mechid.identification.search.solve import solve
from synthetic import NOISE_NM, bench, displaced, truth, with_leading

FREE = {"housing.gain": 1.0, "housing.damping": 1.0}
DRAWS = 3


@pytest.fixture(scope="module")
def made():
    """Return a problem at its optimum, its windows, and draws of its record with noise of their own."""
    campaign = bench(displaced(truth(), FREE), truth(), "full_46", seed=6, seconds=0.2)
    problem = make_problem(campaign, 1)
    windows = problem.whole_windows()
    q = solve(problem, problem.start, windows).q
    (target,) = problem.targets
    (clean,) = problem.model.predict(target, q, target.samples)
    rng = np.random.default_rng(9)
    noise = NOISE_NM * rng.standard_normal((DRAWS, target.samples))
    draws = [replace(problem, targets=(with_leading(target, measured=clean + r),)) for r in noise]
    return problem, q, windows, draws


def test_draws_arrive_where_the_solver_ends(made):
    """Truth: the solver's optimum; both stop where the cost falls by less than 1e-3 sigmas squared."""
    problem, q, windows, draws = made
    chord = chord_at(problem, q, windows, np.ones(q.size, dtype=bool))
    for found, draw in zip(chord_optima(chord, draws, q, windows), draws, strict=True):
        expected = solve(draw, q, windows)
        assert found.cost == pytest.approx(expected.triangle.cost, abs=2.0 * SEARCH.negligible_fall)
        sigma = 1.0 / np.linalg.norm(expected.triangle.jacobian, axis=0)
        assert np.abs((found.q - expected.q) / sigma).max() < 0.1


def test_what_is_held_does_not_move(made):
    problem, q, windows, draws = made
    chord = chord_at(problem, q, windows, np.array([True, False]))
    for found in chord_optima(chord, draws, q, windows):
        assert found.q[1] == q[1]
        assert found.q[0] != q[0]


def test_derivatives_that_are_too_many_are_not_kept(made, monkeypatch):
    problem, q, windows, _ = made
    samples = problem.targets[0].samples
    monkeypatch.setattr(module, "REFIT", replace(REFIT, most_numbers=samples * q.size - 1))
    assert chord_at(problem, q, windows, np.ones(q.size, dtype=bool)) is None
