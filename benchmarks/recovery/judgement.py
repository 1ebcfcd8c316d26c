"""Whether a fit found the truth: by the residual sum, by its errors in sigmas, by the sigmas themselves."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from mechid.campaign import Campaign
from mechid.identification.identify import make_problem
from mechid.identification.output_error.problem import Problem
from mechid.identification.result.fit import Fit
from mechid.identification.search.solve import covariance
from mechid.plant.mechanism import Mechanism
from recovery.campaigns import NOISE_NM, SUBSTEPS

MOST_EXCESS = 1.0
"""By how many sigma^2 the residual sum may exceed that at the truth."""
MOST_ERROR = 5.0
"""Sigmas that a parameter may be off."""
MOST_RATIO = 1.5
"""Factor by which a sigma may differ from the bound, either way."""


@dataclass(frozen=True)
class Truth:
    """What is known of a campaign's mechanism: its values, the residual sum at them, the bounds of the sigmas.

    The residual sum is in units of the noise's own sigma squared, offset and drift fitted; the bounds are
    those of Cramer and Rao from the exact Jacobian at the truth.
    """

    problem: Problem
    values: Mapping[str, float]
    cost: float
    bounds: Mapping[str, float]


def truth_of(campaign: Campaign, mechanism: Mechanism) -> Truth:
    """Return the key of a campaign that a mechanism made."""
    problem = make_problem(campaign, 1).with_sigmas({r.name: NOISE_NM for r in campaign.records})
    problem = replace(problem, substeps=SUBSTEPS)
    values = {p.name: p.value for p in mechanism.parameters.values() if p.is_free}
    q = problem.space.from_values({**{p.name: p.value for p in mechanism.parameters.values()}, **values})
    triangle = problem.joint(q, problem.whole_windows())
    names, slopes = problem.space.value_jacobian(q)
    bounds = np.sqrt(np.diag(slopes @ covariance(triangle) @ slopes.T))
    return Truth(problem, values, triangle.cost, dict(zip(names, map(float, bounds), strict=True)))


def cost_of(truth: Truth, mechanism: Mechanism) -> float:
    """Return the residual sum of the whole records at a mechanism's values, in units of sigma squared."""
    q = truth.problem.space.from_values({p.name: p.value for p in mechanism.parameters.values()})
    return float(np.sum(np.square(truth.problem.norms(q, truth.problem.whole_windows()))))


def judged(truth: Truth, fit: Fit) -> dict[str, object]:
    """Return the verdict on a fit: `success`, and the three figures it rests on."""
    excess = cost_of(truth, fit.mechanism) - truth.cost
    errors = {name: _error(fit, name, value) for name, value in truth.values.items()}
    ratios = {name: _ratio(fit, name, bound) for name, bound in truth.bounds.items()}
    worst = max(errors, key=lambda name: errors[name])
    furthest = max(ratios, key=lambda name: abs(math.log(ratios[name])))
    reasons = []
    if not excess <= MOST_EXCESS:
        reasons.append("cost")
    if not errors[worst] <= MOST_ERROR:
        reasons.append("error")
    if not abs(math.log(ratios[furthest])) <= math.log(MOST_RATIO):
        reasons.append("sigma")
    return {
        "success": not reasons,
        "reasons": reasons,
        "excess": excess,
        "worst": [worst, errors[worst]],
        "sigma_ratio": [furthest, ratios[furthest]],
        "errors": errors,
    }


def _error(fit: Fit, name: str, value: float) -> float:
    """Return |error| in the fit's own sigmas, inf where it gives none; a phase is compared on the circle."""
    found = fit.parameters[name]
    if not found.std_error:
        return math.inf
    error = found.value - value
    if found.unit == "deg":
        error = (error + 180.0) % 360.0 - 180.0
    return abs(error) / found.std_error


def _ratio(fit: Fit, name: str, bound: float) -> float:
    """Return the fit's sigma over its bound, inf where it gives none.

    At a stick/slip threshold the errors count the step that was refused, of which no bound knows: there without it.
    """
    found = fit.parameters[name]
    error = found.std_error_white if fit.outcome.has_stopped_short else found.std_error
    return error / bound if error else math.inf
