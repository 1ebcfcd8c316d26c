"""Standard errors against what they claim: the scatter of estimates over seeded draws of the noise."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from mechid.identification.search.solve import covariance, solve
from mechid.identification.uncertainty.covariance import _fit_colours, _record_score, residual, uncertainty
from mechid.signal.autoregression import Autoregression, autocovariance
from synthetic import COMMANDS, NOISE_NM, displaced, measuring, record, torque_of, truth, with_leading

FREE = {"gear.stiffness": 1.005, "gear.damping": 1.1, "stepper.torque_constant": 0.99}
"""Few parameters, started off their truth; over 0.1 s the torque is all but linear in them."""
AR = (1.0, -1.6, 0.7)
"""A coloured noise of low frequency: poles at radius 0.84 and 17 deg, 470 Hz, where the mechanism answers too."""


def white(rng, samples):
    return NOISE_NM * rng.standard_normal(samples)


def coloured(rng, samples):
    """Return AR(2) noise past its transient, of the same RMS; sigma of the process in closed form."""
    _, a1, a2 = AR
    variance = (1.0 + a2) / ((1.0 - a2) * ((1.0 + a2) ** 2 - a1**2))
    e = NOISE_NM / np.sqrt(variance) * rng.standard_normal(samples + 500)
    return lfilter([1.0], AR, e)[500:]


@dataclass(frozen=True)
class Scatter:
    """Errors of the estimates, (draws, n), and the covariances reported with each, (draws, n, n)."""

    errors: np.ndarray
    white: np.ndarray
    robust: np.ndarray

    def variance_ratio(self, covariances):
        """Return the mean squared error of each parameter in units of its reported variance; 1 is honest."""
        return np.mean(self.errors**2 / np.diagonal(covariances, axis1=1, axis2=2), axis=0)

    def chi_square(self, covariances):
        """Return the mean of e^T C^-1 e / n; 1 is honest, correlations included."""
        solved = np.linalg.solve(covariances, self.errors[:, :, None])[:, :, 0]
        return float(np.mean(np.sum(self.errors * solved, axis=1))) / self.errors.shape[1]


def scatter(factors, names, noise, draws, *, seconds, seed):
    """Fit `draws` times the truth's torque with fresh noise, from the same displaced start."""
    space = SearchSpace(displaced(truth(), factors))
    exact = SearchSpace(truth().with_free(tuple(factors))).start
    torque = {name: torque_of(truth(), COMMANDS[name], round(seconds * 1e4) + 1) for name in names}
    problem = Problem(space, tuple(target_of(record(n, y, COMMANDS[n])) for n, y in torque.items()), substeps=2)
    problem = problem.with_sigmas(dict.fromkeys(names, NOISE_NM))
    found = []
    for rng in np.random.default_rng(seed).spawn(draws):
        targets = tuple(measuring(t, torque[t.name] + noise(rng, t.samples)) for t in problem.targets)
        here = replace(problem, targets=targets)
        solution = solve(here, here.start, here.whole_windows())
        assert solution.converged
        u = uncertainty(here, solution.q, here.whole_windows(), solution.triangle, np.ones(here.size, dtype=bool))
        found.append((solution.q - exact, u.white, u.robust))
    return Scatter(*map(np.array, zip(*found, strict=True)))


@pytest.mark.parametrize("linear", [0, 1, 2])
def test_the_score_of_white_noise_is_in_the_triangle(linear):
    """Truth: J^T J of the reduced triangle, offset and drift dropped; the sum over samples is streamed."""
    torque = torque_of(truth(), COMMANDS["full_46"], 801)
    target = with_leading(target_of(record("full_46", torque, COMMANDS["full_46"])), linear=linear, sigma=NOISE_NM)
    problem = Problem(SearchSpace(displaced(truth(), FREE)), (target,), substeps=2)
    white = Autoregression(np.array([1.0]), 0.003)
    variance, parts = _record_score(problem, target, problem.start, (100, 801), (white,))
    J = problem.triangle(target, problem.start, (100, 801)).jacobian
    np.testing.assert_allclose(
        variance, J.T @ J * (0.003 / NOISE_NM) ** 2, rtol=1e-9, atol=1e-9 * np.abs(variance).max()
    )
    for kind in (parts.phases, parts.stretches):
        np.testing.assert_allclose(kind.information.sum(axis=0), J.T @ J, rtol=1e-9, atol=1e-9 * np.abs(J.T @ J).max())


DRAWS = 100


@pytest.fixture(scope="module")
def under_white_noise():
    return scatter(FREE, ["full_46"], white, DRAWS, seconds=0.1, seed=21)


@pytest.fixture(scope="module")
def under_coloured_noise():
    return scatter(FREE, ["full_46"], coloured, DRAWS, seconds=0.2, seed=22)


def error_of_ratio(draws, size=1):
    """Return the standard error of a mean chi-square of `size` degrees of freedom, per degree, over draws."""
    return np.sqrt(2.0 / (draws * size))


@pytest.mark.parametrize("noise", ["under_white_noise", "under_coloured_noise"])
def test_estimates_scatter_about_the_truth(noise, request):
    """Truth: the mechanism that made the records; the mean error is within 4 of its own standard errors."""
    errors = request.getfixturevalue(noise).errors
    assert np.all(np.abs(errors.mean(axis=0)) < 4.0 * errors.std(axis=0) / np.sqrt(DRAWS))


@pytest.mark.parametrize("kind", ["white", "robust"])
def test_under_white_noise_both_errors_hold(under_white_noise, kind):
    """Truth: the scatter, known to sqrt(2 / draws); each parameter, and all with their correlation."""
    reported = getattr(under_white_noise, kind)
    ratio, chi_square = under_white_noise.variance_ratio(reported), under_white_noise.chi_square(reported)
    assert ratio == pytest.approx(1.0, abs=4.0 * error_of_ratio(DRAWS))
    assert chi_square == pytest.approx(1.0, abs=4.0 * error_of_ratio(DRAWS, len(FREE)))


def test_under_coloured_noise_the_robust_error_holds(under_coloured_noise):
    """Truth: the scatter; the colour itself is estimated from each record, which costs another tenth."""
    reported = under_coloured_noise.robust
    ratio, chi_square = under_coloured_noise.variance_ratio(reported), under_coloured_noise.chi_square(reported)
    assert ratio == pytest.approx(1.0, abs=0.1 + 4.0 * error_of_ratio(DRAWS))
    assert chi_square == pytest.approx(1.0, abs=0.1 + 4.0 * error_of_ratio(DRAWS, len(FREE)))


def test_under_coloured_noise_the_white_error_is_far_too_small(under_coloured_noise):
    """Truth: the scatter; errors are more than 1.7 times what the white covariance claims, for every parameter."""
    assert np.all(under_coloured_noise.variance_ratio(under_coloured_noise.white) > 3.0)


@pytest.fixture(scope="module")
def one_fit():
    """Return a problem with one coloured record, its whole window, its triangle, at the truth."""
    torque = torque_of(truth(), COMMANDS["full_46"], 3001) + coloured(np.random.default_rng(23), 3001)
    own = with_leading(target_of(record("full_46", torque, COMMANDS["full_46"])), sigma=NOISE_NM)
    problem = Problem(SearchSpace(truth().with_free(tuple(FREE))), (own,), substeps=2)
    return problem, problem.whole_windows(), problem.joint(problem.start, problem.whole_windows())


def test_the_robust_covariance_is_the_sandwich_of_the_dense_matrices(one_fit):
    """Truth: (J^T J)^-1 J^T C J (J^T J)^-1, J by differences, C the Toeplitz matrix of the model's own process."""
    problem, windows, triangle = one_fit
    target, q, n = problem.targets[0], problem.start, 3001
    u = uncertainty(problem, q, windows, triangle, np.ones(problem.size, dtype=bool))
    J = np.empty((n, problem.size))
    for j in range(problem.size):
        h = np.zeros(problem.size)
        h[j] = 1e-6
        J[:, j] = (problem.model.predict(target, q + h, n)[0] - problem.model.predict(target, q - h, n)[0]) / 2e-6
    phi = np.vander(np.linspace(-1.0, 1.0, n), 2)
    J -= phi @ np.linalg.lstsq(phi, J, rcond=None)[0]
    (colour,) = _fit_colours(problem, target, q, windows["full_46"])
    impulse = lfilter([colour.sigma], colour.coefficients, np.eye(1, 2000)[0])
    C = toeplitz(np.pad(autocovariance(impulse, 400) * impulse.size, (0, n - 401)))
    inverse = np.linalg.inv(J.T @ J)
    sandwich = inverse @ J.T @ C @ J @ inverse
    size = np.sqrt(np.outer(np.diag(sandwich), np.diag(sandwich)))
    np.testing.assert_allclose(u.robust / size, sandwich / size, atol=0.01)
    np.testing.assert_allclose(u.white, inverse * NOISE_NM**2, rtol=1e-3)


def test_the_colour_of_the_residual_is_that_of_the_noise(one_fit):
    """Truth: the AR(2) process that was added; the residual at the truth is that noise without offset and drift."""
    problem, windows, _ = one_fit
    (model,) = _fit_colours(problem, problem.targets[0], problem.start, windows["full_46"])
    assert model.order == 2
    assert model.coefficients == pytest.approx(AR, abs=0.06)
    (r,) = residual(problem, problem.targets[0], problem.start, windows["full_46"])
    assert abs(r.mean()) < 1e-9
    assert float(np.sqrt(np.mean(r**2))) == pytest.approx(NOISE_NM, rel=0.1)


def test_what_is_not_seen_has_no_variance_and_leaves_that_of_the_rest(one_fit):
    """Truth: the covariance of the problem without that coordinate."""
    problem, windows, triangle = one_fit
    u = uncertainty(problem, problem.start, windows, triangle, np.array([True, False, True]))
    for matrix in (u.white, u.robust):
        assert not matrix[1].any()
        assert not matrix[:, 1].any()
    alone = covariance(replace(triangle, jacobian=triangle.jacobian[:, [0, 2]]))
    np.testing.assert_allclose(u.white[np.ix_([0, 2], [0, 2])], alone, rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("noise", [white, coloured])
def test_all_parameters_of_a_campaign_scatter_as_reported(noise):
    """Truth: the scatter of all 15 parameters over 60 draws of four records; the search starts beside the truth."""
    names = [p.name for p in truth().free]
    factors = {name: 1.002 if k % 2 else 0.998 for k, name in enumerate(names)}
    found = scatter(factors, list(COMMANDS), noise, 60, seconds=0.4, seed=24)
    error = error_of_ratio(60, len(names))
    assert found.chi_square(found.robust) == pytest.approx(1.0, abs=0.15 + 4.0 * error)
    assert np.all(np.abs(found.variance_ratio(found.robust) - 1.0) < 0.15 + 4.0 * error_of_ratio(60))
    if noise is coloured:
        assert found.chi_square(found.white) > 2.0
    else:
        assert found.chi_square(found.white) == pytest.approx(1.0, abs=4.0 * error)
