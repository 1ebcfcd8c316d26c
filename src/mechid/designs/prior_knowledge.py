"""Knowledge before the next test: possible mechanisms and existing information."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.designs.information import prior_points, range_information, without_offsets
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.result.fit import Optimum
from mechid.parameter import Status


@dataclass(frozen=True, eq=False)
class PriorKnowledge:
    """Knowledge before the next test.

    Attributes
    ----------
    space : SearchSpace
        Its mechanism has the assumed values, with all estimated parameters free.
    points : (s, n)
        Possible mechanisms, the assumed one first, in search coordinates.
    before : (n, n)
        Fisher information from bounds and priors of the file, and from the records of a fit.
    known : (n, n) or None
        Fisher information of the fit alone; None before a fit.
    priors : mapping of str to (float, float)
        Priors of the mechanism file, as identify uses them.
    sigma : float or None
        Noise level of the fit, N m.
    """

    space: SearchSpace
    points: FloatArray
    before: FloatArray
    known: FloatArray | None = None
    priors: Mapping[str, tuple[float, float]] | None = None
    sigma: float | None = None


def before_test(campaign: Campaign, count: int, seed: int) -> PriorKnowledge:
    """Return the knowledge given the mechanism file alone: parameters within the usual errors of catalogues."""
    space = SearchSpace(campaign.mechanism)
    priors = {q.name: (q.value, q.sigma) for q in campaign.mechanism.free if q.sigma}
    counted = priors if campaign.options.priors == "fit" else {}
    return PriorKnowledge(space, prior_points(space, count, seed), range_information(space), priors=counted)


def after_fit(optimum: Optimum, count: int, seed: int) -> PriorKnowledge:
    """Return the knowledge after a fit: its estimate, and draws from its covariance.

    Parameters that the fit held because its records did not determine them are free again: a further record may.
    """
    problem, size = optimum.problem, optimum.problem.space.size
    mechanism = problem.space.at(optimum.q[:size])
    held = {
        name: replace(mechanism.parameters[name], status=Status.FREE)
        for name, p in optimum.parameters.items()
        if p.status == Status.FROZEN and name in mechanism.parameters
    }
    space = SearchSpace(mechanism.with_parameters(held), problem.space.polar)
    wider = replace(problem, space=space)
    q = np.concatenate([space.start, optimum.q[size:]])
    J = wider.joint(q, optimum.windows).jacobian
    known = without_offsets(J, space.size)
    before = known + range_information(space)
    values, vectors = np.linalg.eigh(before)
    root = vectors / np.sqrt(np.maximum(values, 1e-300))
    # Streams 1, 2 and 3 of a seed belong to priors, draws of a fit, and draws of the reliability check.
    steps = np.random.default_rng((seed, 2)).standard_normal((count - 1, space.size)) @ root.T
    points = np.vstack([space.start, np.clip(space.start + steps, space.lower, space.upper)])
    sigma = float(np.median([t.leading.sigma for t in problem.targets]))
    return PriorKnowledge(space, points, before, known, {}, sigma)
