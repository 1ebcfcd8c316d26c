"""Refits of a planned problem to draws of noise, in units of the errors predicted for it."""

from dataclasses import replace

import numpy as np

from mechid.designs.prediction import predicted_errors
from mechid.identification.computation.parallel import map_tasks
from mechid.identification.search.solve import solve


def scatter(problem, draws, seed, workers=1):
    """Return the refits of draws, (draws, k) values of the file; each begins at the values that made the records."""
    q, whole = problem.start, problem.whole_windows()
    torques = {t.name: problem.model.predict(t, q, t.samples) for t in problem.targets}

    def measured(target, rng):
        channel, (torque,) = target.leading, torques[target.name]
        noise = channel.sigma * rng.standard_normal(target.samples) + 0.01 * rng.standard_normal()
        return replace(target, channels=(replace(channel, measured=torque + noise),))

    def refit(number):
        rng = np.random.default_rng((seed, number))
        targets = tuple(measured(t, rng) for t in problem.targets)
        found = solve(replace(problem, targets=targets), q, whole)
        assert found.converged
        values = problem.space.values(found.q)
        return [values[name] for name in sorted(values)]

    return np.array(map_tasks(refit, range(draws), workers))


def normalised(problem, draws, seed, workers=1):
    """Return deviations from the truth over the predicted errors, (draws, k), and their squared distance, (draws,)."""
    errors = predicted_errors(problem, problem.start)
    order = np.argsort(errors.names)
    off = scatter(problem, draws, seed, workers) - errors.values[order]
    covariance = errors.covariance[np.ix_(order, order)]
    sigma = np.sqrt(np.diag(covariance))
    scaled = covariance / np.outer(sigma, sigma)
    return off / sigma, np.einsum("di,ij,dj->d", off / sigma, np.linalg.inv(scaled), off / sigma)
