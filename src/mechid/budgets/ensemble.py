"""Ensemble of units and conditions, and weighted draws of its members."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri
from scipy.stats import qmc

from mechid.arrays import FloatArray
from mechid.budgets.other_errors import OtherError
from mechid.budgets.settings import LEVEL


@dataclass(frozen=True, eq=False)
class Members:
    """Draws of an ensemble.

    Attributes
    ----------
    draws : (r, n, k)
        Values of the spread quantities, in standard deviations, by replica.
    weights : (r, n)
        Weight of each draw; they add to 1 in each replica.
    """

    draws: FloatArray
    weights: FloatArray


@dataclass(frozen=True, eq=False)
class Ensemble:
    """Spread over units and conditions.

    Attributes
    ----------
    names : tuple of str, (s,)
    spread : (s,)
        Standard deviations of parameters; their derivatives are the last columns of a response's.
    errors : tuple of OtherError, (e,)
        Errors of other sources.
    variables : tuple of str, (d,)
        Independent variables: parameters, errors, groups of errors.
    follows : (d, s + e)
        1 where a parameter or an error follows a variable.
    seed : int
    """

    names: tuple[str, ...]
    spread: FloatArray
    errors: tuple[OtherError, ...]
    variables: tuple[str, ...]
    follows: FloatArray
    seed: int

    def along(self, direction: FloatArray) -> Members:
        """Return members concentrated along a direction of the variables, (d,) of length 1.

        Each replica is a separate scrambled Sobol sequence whose first coordinate lies along the direction. Draws are
        stretched outwards and weighted by the ratio of the densities (importance sampling). The result is therefore
        unbiased for any direction; a good direction makes it precise.
        """
        # Weights degenerate with the number of stretched axes: the stretch across is shared among them.
        across = 1.0 + LEVEL.stretch_across / max(direction.size - 1, 1)
        stretch = np.array([LEVEL.stretch, *[across] * (direction.size - 1)])
        white = self._white()
        far = white * stretch
        # The constant factor of the densities' ratio cancels in the normalisation.
        weights = np.exp(0.5 * np.sum(white**2 - far**2, axis=2))
        return Members(far @ _reflection_to(direction) @ self.follows, weights / weights.sum(axis=1, keepdims=True))

    def _white(self) -> FloatArray:
        """Return quasi-random normal draws, (r, n, d)."""
        # Spawned seeds make the replicas independent of each other.
        seeds = np.random.SeedSequence(self.seed).spawn(LEVEL.replicas)
        uniform = [qmc.Sobol(len(self.variables), seed=np.random.default_rng(s)).random(LEVEL.members) for s in seeds]
        # A Sobol point may be exactly 0 or 1, whose normal quantile is infinite.
        return np.asarray(ndtri(np.clip(uniform, 1e-12, 1.0 - 1e-12)), dtype=np.float64)


def make_ensemble(names: Sequence[str], spread: FloatArray, errors: Sequence[OtherError], seed: int) -> Ensemble:
    """Return the ensemble; errors of one group vary together."""
    variables: dict[str, list[int]] = {name: [k] for k, name in enumerate(names) if spread[k] > 0.0}
    for k, error in enumerate(errors):
        if error.spread_rad > 0.0:
            # Errors of the same name still vary independently, unless they share a group.
            alone = f"error {error.name}" if f"error {error.name}" not in variables else f"error {error.name} ({k})"
            variables.setdefault(f"errors of {error.group}" if error.group else alone, []).append(len(names) + k)
    follows = np.zeros((len(variables), len(names) + len(errors)))
    for row, columns in zip(follows, variables.values(), strict=True):
        row[columns] = 1.0
    return Ensemble(tuple(names), spread, tuple(errors), tuple(variables), follows, seed)


def _reflection_to(direction: FloatArray) -> FloatArray:
    """Return an orthogonal matrix whose first row is the direction: a Householder reflection of the first axis."""
    first = np.eye(direction.size)[0]
    normal = direction - first
    square = float(normal @ normal)
    reflection = np.eye(direction.size)
    # A direction along the first axis needs no reflection, and has no normal to reflect by.
    return np.asarray(reflection - 2.0 * np.outer(normal, normal) / square if square > 1e-24 else reflection)
