"""Errors beyond noise: parameters on a bound, the choice of the right clock, and held parameters.

The unbounded Newton step shows how far beyond a bound of the mechanism file the optimum of the records lies. Where that
distance is within chance, the records allow the bound, and a one-sided interval is reported. Where it is larger, the
records contradict the bound, and the shift that the bound forces on the other parameters counts as their error.

The records show how much the driver's clock and the recorder's differ, but not which one is wrong. Where the campaign
does not declare the right one, the recorder's time is used, and the step to the optimum of the other choice counts as a
standard error. It is one error common to all parameters, since one clock shifts them all.

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
from mechid.identification.result.search_state import HeldParameter
from mechid.identification.uncertainty.settings import ERRORS
from mechid.parameter import Status


@dataclass(frozen=True)
class OnBound:
    """A parameter on its bound, by dotted name.

    Attributes
    ----------
    name : str
    beyond : float
        Distance of the unbounded optimum beyond the bound, in standard errors.
    interval : (float, float)
        95 % interval inside the bound, in the file's unit; the bound is its first or last value. Where the records
        contradict the bound, the contradiction counts as a further error.
    """

    name: str
    beyond: float
    interval: tuple[float, float]

    @property
    def is_contradicted(self) -> bool:
        """Whether the records contradict the bound by more than chance."""
        return self.beyond >= ERRORS.contradiction


def newton_step(triangle: Triangle, counted: BoolArray) -> FloatArray:
    """Return the Newton step to the optimum, (n,), zero for coordinates that are not counted."""
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
        Coordinates on a bound; for a detent, both of its coordinates.
    step : (n,)
        The unbounded Newton step.
    covariance : (n, n)
        Covariance of the unbounded coordinates by noise alone. A bound that excludes the truth makes parts of the
        records disagree; errors widened by that disagreement would hide the contradiction.
    """
    found: dict[str, OnBound] = {}
    for j in np.flatnonzero(on):
        name = problem.coordinates.names[j]
        if name in found:  # the sine of a detent whose cosine is already listed
            continue
        outward = _outward_direction(problem, q, int(j))
        sigma = math.sqrt(max(float(outward @ covariance @ outward), 0.0))
        away = max(float(outward @ step), 0.0)
        beyond = away / sigma if sigma > 0.0 else 0.0
        # Beyond chance, the distance to the unbounded optimum is a model error and is added to the noise.
        spread = math.hypot(sigma, away) if beyond >= ERRORS.contradiction else sigma
        outside = away / spread if spread > 0.0 else 0.0
        # 95 % quantile of a normal distribution truncated at the bound; its centre lies `away` outside.
        inside = spread * -float(ndtri(0.05 * float(ndtr(-outside)))) - away
        within = problem.coordinates.clip(q - inside * outward)
        ends = [problem.coordinates.values(x)[name] for x in (_move_to_bound(problem, q, int(j), outward), within)]
        found[name] = OnBound(name, beyond, (min(ends), max(ends)))
    return list(found.values())


def _move_to_bound(problem: Problem, q: FloatArray, j: int, outward: FloatArray) -> FloatArray:
    """Return the point with coordinate j exactly on its bound, which the solver only approaches; detents unchanged."""
    at = problem.coordinates
    if j < at.space.size and at.space.coordinates[j].kind == "cosine":
        return q
    edge = q.copy()
    edge[j] = at.lower[j] if outward[j] < 0.0 else at.upper[j]
    return edge


def _outward_direction(problem: Problem, q: FloatArray, j: int) -> FloatArray:
    """Return the unit direction in which coordinate j crosses its bound, (n,)."""
    at, out = problem.coordinates, np.zeros(q.size)
    own = at.space.coordinates[j] if j < at.space.size else None
    if own is not None and own.kind == "cosine":
        out[j : j + 2] = q[j : j + 2] / np.linalg.norm(q[j : j + 2])
    else:
        out[j] = -1.0 if q[j] - at.lower[j] < at.upper[j] - q[j] else 1.0
    return out


def clocks_differ(problem: Problem, q: FloatArray) -> bool:
    """Tell whether the driver's time differs from the recorder's at `q`, in a fit that uses the recorder's."""
    return any(problem.coordinates.timing(target, q).stretch != 1.0 for target in problem.targets)


def clock_step(problem: Problem, q: FloatArray, windows: Windows, triangle: Triangle, counted: BoolArray) -> FloatArray:
    """Return the step to the optimum in the driver's time, (n,); zero where the clocks agree.

    Parameters
    ----------
    problem : Problem
    q : (n,)
        Optimum in the recorder's time.
    windows : mapping of record to (first, stop)
    triangle : Triangle
        Linearization of the problem at `q`.
    counted : (n,) of bool
        The coordinates that are estimated.
    """
    zero = np.zeros(q.size)
    if not clocks_differ(problem, q):
        return zero
    other = replace(problem, targets=tuple(replace(t, clock_reference="driver") for t in problem.targets))
    moved = other.joint(q, windows)
    if not np.isfinite(moved.norm):
        return zero
    # The solver stops at a small gradient; both steps contain it, so it cancels.
    return newton_step(moved, counted) - newton_step(triangle, counted)


def clock_warnings(parameters: Mapping[str, ParameterEstimate]) -> tuple[str, ...]:
    """Warn where the choice of the recorder's clock shifts a value by more than its noise."""
    moved = [p for p in parameters.values() if p.std_error_clock and p.std_error_noise and p.value]
    worst = max(moved, key=lambda p: (p.std_error_clock or 0.0) / (p.std_error_noise or 1.0), default=None)
    if worst is None or worst.std_error_clock is None or worst.std_error_clock < (worst.std_error_noise or 0.0):
        return ()
    share = abs(worst.std_error_clock / worst.value)
    return (
        "the driver's clock and the recorder's differ; no record tells which is right, so the recorder's is used. "
        f"With the driver's, {worst.name} would differ by {worst.std_error_clock:.3g} {worst.unit}, {share:.2g} of its "
        "value; the standard errors include this as std_error_clock; if you know which clock is right, write "
        'clock_reference = "recorder" or "driver" in campaign.toml',
    )


def consider_covariance(
    problem: Problem,
    q: FloatArray,
    windows: Windows,
    held: Sequence[HeldParameter],
    names: Sequence[str],
    white: FloatArray,
) -> FloatArray:
    """Return the covariance that the held parameters' sigmas add, (k, k), in the file's coordinates and units.

    Parameters
    ----------
    problem : Problem
        The problem in which they are held.
    q : (n,)
    windows : mapping of record to (first, stop)
    held : sequence of HeldParameter
        Entries without sigma add nothing.
    names : sequence of str, (k,)
        The estimated parameters.
    white : (k, k)
        Covariance of these, in the file's coordinates and units.
    """
    total = np.zeros_like(white)
    for parameter in held:
        if parameter.sigma:
            moved = _shift_per_unit(problem, q, windows, parameter.name, names, white) * parameter.sigma
            total += np.outer(moved, moved)
    return total


def _shift_per_unit(
    problem: Problem, q: FloatArray, windows: Windows, held: str, names: Sequence[str], white: FloatArray
) -> FloatArray:
    """Return the shift of the estimates per unit of the held parameter, (k,)."""
    # The parameter is freed to get its column of the Jacobian; a Fourier pair as amplitude and phase, as in the file.
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
