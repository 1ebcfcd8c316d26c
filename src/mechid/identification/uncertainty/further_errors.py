"""Errors beyond noise: parameters on a bound, not knowing which clock is right, and parameters that are held.

The unbounded Newton step says how far beyond a bound of the mechanism file the records want a coordinate. By less than
chance, the bound is one that they allow, and the truth may lie within: an interval on one side. By more, they
contradict it, and what the bound forces on the other parameters counts as an error of theirs.

No record tells whether the driver's clock or the recorder's is off, only how much they differ. Where the campaign does
not say which one is right, the recorder's time is taken, and the step to the optimum of the other choice is a standard
error of its own: of all parameters together, since one clock moves them all.

Consider covariance: an error c of a held parameter moves the estimate by -P J^T J_c c, with P the covariance of the
estimated ones, J their derivatives and J_c that of the held one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtr, ndtri

from mechid.arrays import BoolArray, FloatArray
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.reduction import Triangle
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.result.parameter_estimate import ParameterEstimate
from mechid.identification.result.search_state import Frozen
from mechid.identification.uncertainty.settings import ERRORS
from mechid.parameter import Status


@dataclass(frozen=True)
class OnBound:
    """A parameter on its bound, by dotted name.

    Attributes
    ----------
    name : str
    beyond : float
        How far beyond it the records want it, in standard errors.
    interval : (float, float)
        95 % of what they leave within, in the file's unit, the bound first or last. Where they contradict the bound,
        the contradiction counts as a further error.
    """

    name: str
    beyond: float
    interval: tuple[float, float]

    @property
    def contradicted(self) -> bool:
        """Whether that is more than chance."""
        return self.beyond >= ERRORS.contradicted


def newton_step(triangle: Triangle, counted: BoolArray) -> FloatArray:
    """Return the step to where the derivatives put the optimum, (n,), zero where nothing is counted."""
    J = triangle.jacobian[:, counted]
    size = np.linalg.norm(J, axis=0)
    size[size == 0.0] = 1.0
    step = np.zeros(triangle.jacobian.shape[1])
    step[counted] = np.linalg.lstsq(J / size, -triangle.fun, rcond=None)[0] / size
    return step


def on_bounds(
    problem: Problem, q: FloatArray, on: BoolArray, step: FloatArray, covariance: FloatArray
) -> list[OnBound]:
    """Return the parameters on their bounds.

    Parameters
    ----------
    problem : Problem
    q : (n,)
    on : (n,) of bool
        Coordinates on a bound; both of a detent's.
    step : (n,)
        The unbounded Newton step.
    covariance : (n, n)
        Of the coordinates where none is bounded, by noise alone: a bound that excludes the truth makes parts of the
        records disagree, and errors widened by that would hide it.
    """
    found: dict[str, OnBound] = {}
    for j in np.flatnonzero(on):
        name = problem.coordinates.names[j]
        if name in found:  # the sine of a detent whose cosine has said it
            continue
        outward = _outward(problem, q, int(j))
        sigma = math.sqrt(max(float(outward @ covariance @ outward), 0.0))
        away = max(float(outward @ step), 0.0)
        beyond = away / sigma if sigma > 0.0 else 0.0
        # Beyond chance the model is wrong by as much as the records are off: that counts as an error of its own.
        spread = math.hypot(sigma, away) if beyond >= ERRORS.contradicted else sigma
        outside = away / spread if spread > 0.0 else 0.0
        inside = spread * -float(ndtri(0.05 * float(ndtr(-outside)))) - away
        within = problem.coordinates.clip(q - inside * outward)
        ends = [problem.coordinates.values(x)[name] for x in (_at_edge(problem, q, int(j), outward), within)]
        found[name] = OnBound(name, beyond, (min(ends), max(ends)))
    return list(found.values())


def _at_edge(problem: Problem, q: FloatArray, j: int, outward: FloatArray) -> FloatArray:
    """Return a point with a coordinate on its very bound, which the solver only comes near; a detent's as it is."""
    at = problem.coordinates
    if j < at.space.size and at.space.coordinates[j].kind == "cosine":
        return q
    edge = q.copy()
    edge[j] = at.lower[j] if outward[j] < 0.0 else at.upper[j]
    return edge


def _outward(problem: Problem, q: FloatArray, j: int) -> FloatArray:
    """Return the direction in which a coordinate on its bound would leave it, (n,), of length 1."""
    at, out = problem.coordinates, np.zeros(q.size)
    own = at.space.coordinates[j] if j < at.space.size else None
    if own is not None and own.kind == "cosine":
        out[j : j + 2] = q[j : j + 2] / np.linalg.norm(q[j : j + 2])
    else:
        out[j] = -1.0 if q[j] - at.lower[j] < at.upper[j] - q[j] else 1.0
    return out


def clocks_differ(problem: Problem, q: FloatArray) -> bool:
    """Tell whether the recorder's time is taken for the true one at a point where the driver's differs from it."""
    return any(problem.coordinates.timing(target, q).stretch != 1.0 for target in problem.targets)


def clock_step(problem: Problem, q: FloatArray, windows: Windows, triangle: Triangle, counted: BoolArray) -> FloatArray:
    """Return the step of the coordinates to the optimum in the driver's time, (n,); zero where the clocks agree.

    Parameters
    ----------
    problem : Problem
    q : (n,)
        Its optimum in the recorder's time.
    windows : mapping of record to (first, stop)
    triangle : Triangle
        The problem at `q`.
    counted : (n,) of bool
        The coordinates that are estimated.
    """
    none = np.zeros(q.size)
    if not clocks_differ(problem, q):
        return none
    other = replace(problem, targets=tuple(replace(t, clock_reference="driver") for t in problem.targets))
    moved = other.joint(q, windows)
    if not np.isfinite(moved.norm):
        return none
    # what is left of the gradient at `q` is in both
    return newton_step(moved, counted) - newton_step(triangle, counted)


def clock_warnings(parameters: Mapping[str, ParameterEstimate]) -> tuple[str, ...]:
    """Say how far the values rest on the recorder's clock, where that is more than their noise."""
    moved = [p for p in parameters.values() if p.std_error_clock and p.std_error_noise and p.value]
    worst = max(moved, key=lambda p: (p.std_error_clock or 0.0) / (p.std_error_noise or 1.0), default=None)
    if worst is None or worst.std_error_clock is None or worst.std_error_clock < (worst.std_error_noise or 0.0):
        return ()
    share = abs(worst.std_error_clock / worst.value)
    return (
        "the driver's clock and the recorder's differ; no record tells which is right, and the recorder's is taken. "
        f"With the driver's, {worst.name} would differ by {worst.std_error_clock:.3g} {worst.unit}, {share:.2g} of it; "
        "the standard errors include this as std_error_clock; write clock_reference = "
        '"recorder" or "driver" in campaign.toml where you know which',
    )


def consider_covariance(
    problem: Problem, q: FloatArray, windows: Windows, held: Sequence[Frozen], names: Sequence[str], white: FloatArray
) -> FloatArray:
    """Return what the held parameters' sigmas add, (k, k), in the file's coordinates and units.

    Parameters
    ----------
    problem : Problem
        In which they are held.
    q : (n,)
    windows : mapping of record to (first, stop)
    held : sequence of Frozen
        Those without sigma add nothing.
    names : sequence of str, (k,)
        The estimated parameters.
    white : (k, k)
        Their covariance, in the file's coordinates and units.
    """
    total = np.zeros_like(white)
    for parameter in held:
        if parameter.sigma:
            moved = _moved_by(problem, q, windows, parameter.name, names, white) * parameter.sigma
            total += np.outer(moved, moved)
    return total


def _moved_by(
    problem: Problem, q: FloatArray, windows: Windows, held: str, names: Sequence[str], white: FloatArray
) -> FloatArray:
    """Return how far the estimates move for each unit of the held parameter, (k,)."""
    mechanism = problem.space.at(q[: problem.space.size])
    pairs = {name: p.amplitude for p in mechanism.plant.polar_pairs for name in (p.amplitude, p.phase)}
    polar = problem.space.polar | ({pairs[held]} if held in pairs else frozenset())
    freed = replace(mechanism.parameters[held], status=Status.FREE)
    wider = replace(problem, space=SearchSpace(mechanism.with_parameters({held: freed}), polar))
    here = np.concatenate([wider.space.start, q[problem.space.size :]])
    every, slopes = wider.coordinates.value_slopes(here)
    by_file = wider.joint(here, windows).jacobian @ np.linalg.pinv(slopes)
    J, J_c = by_file[:, [every.index(n) for n in names]], by_file[:, every.index(held)]
    return np.asarray(-white @ (J.T @ J_c), dtype=np.float64)
