"""Laws that no null value leads to, or that only a grid does: where a fit of each begins, and what it promises."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mechid.identification.beside.beside import lifted
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.disturbance.scores import Score
from mechid.plant.mechanism import Mechanism
from mechid.plant.superset import Law


def promise(model: Model, law: Law) -> tuple[Score, Mechanism]:
    """Return what a linear fit says that a law would explain, and the mechanism with it at which it says so.

    Of a law that has an amplitude the fit begins where that is zero, at the best of the values that its other
    parameters may have; of another one at its start, which has to be near enough to nothing.
    """
    best, at = -math.inf, law.mechanism
    for mechanism in _points(law):
        fall, amplitude = _fall(model, law, mechanism)
        if fall > best:
            best, at = fall, _at(law, mechanism, amplitude)
    fall = max(best, 0.0)
    return Score(model.worth * fall / model.cost, len(law.own), fall / max(model.misfit, fall, 1.0), model.worth), at


def _points(law: Law) -> Iterator[Mechanism]:
    yield from (law.at_null(values) for values in law.tries or ({},)) if law.null else (law.mechanism,)


def _fall(model: Model, law: Law, mechanism: Mechanism) -> tuple[float, float]:
    """Return by how much the cost falls in a linear fit from a point with a law, and its amplitude there."""
    other = model.in_place_of(law, mechanism)
    q = lifted(model.problem, model.q, other.problem)
    triangle = other.problem.joint(q, model.setting.windows)
    if not np.all(np.isfinite(triangle.jacobian)):
        return -math.inf, 0.0
    step = np.linalg.lstsq(triangle.jacobian, -triangle.fun, rcond=None)[0]
    left = triangle.fun + triangle.jacobian @ step
    there = other.problem.coordinates.values(q + step) if law.null else {}
    return model.cost - float(left @ left), there.get(law.null, 0.0)


def _at(law: Law, mechanism: Mechanism, amplitude: float) -> Mechanism:
    """Return the law's mechanism with the other values of a point and an amplitude, as far as its bounds let it."""
    if not law.null:
        return mechanism
    known = law.mechanism.parameters
    others = {name: mechanism.value(name) for name in law.own if name != law.null}
    within = min(max(amplitude, known[law.null].min), known[law.null].max)
    return law.mechanism.with_values({**others, law.null: within})
