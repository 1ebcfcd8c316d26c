"""Covariance under model error, from the disagreement between parts of the records over the parameters.

Parts are the phases within a step, stretches of time, and whole records. Where their scores scatter no more than noise
explains, the covariance by noise is used unchanged. Where they scatter more, each parameter's variance grows by the
excess: by the phase within the step (a cluster-robust covariance, Liang and Zeger 1986), and by leaving out a quarter
of a record or a record (jackknife, one Newton step each).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.identification.effects.disturbance import Disturbance
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.result.grade import Consistency, Scatter
from mechid.identification.uncertainty.covariance import covariances, scores
from mechid.identification.uncertainty.parts import Parts, RecordParts
from mechid.identification.uncertainty.settings import ERRORS

ROUNDING = 1e-14
"""Share of the largest eigenvalue below which an eigenvalue counts as rounding."""


@dataclass(frozen=True)
class Excess:
    """Scatter of one kind of parts as a covariance, (n, n), and its degrees of freedom."""

    covariance: FloatArray
    dof: float


@dataclass(frozen=True)
class ModelError:
    """Covariance by noise and by the scatter of the records' parts, in search coordinates.

    Attributes
    ----------
    noise : (n, n)
        Covariance by noise alone.
    excesses : tuple of Excess
        Empty where noise explains the scatter.
    """

    noise: FloatArray
    excesses: tuple[Excess, ...] = ()

    def variances(self, maps: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the variance of linear functions of the coordinates, (k,), and a measure of its uncertainty.

        Each kind of parts adds its excess over noise. The second result sums each addition squared over its degrees of
        freedom; variance squared over this sum gives the degrees of freedom of the variance (Welch and Satterthwaite).
        """
        noise = diagonal(maps, self.noise)
        over = [np.maximum(diagonal(maps, e.covariance) - noise, 0.0) for e in self.excesses]
        spread = sum((o**2 / e.dof for o, e in zip(over, self.excesses, strict=True)), np.zeros(len(maps)))
        return noise + sum(over, np.zeros(len(maps))), spread

    @property
    def matrix(self) -> FloatArray:
        """Total covariance, (n, n): each kind of parts adds its excess over noise, in the metric of the noise."""
        seen = np.flatnonzero(np.diag(self.noise) > 0.0)
        total = self.noise.copy()
        if not self.excesses or not seen.size:
            return total
        root, inverse = _square_root(self.noise[np.ix_(seen, seen)])
        # In coordinates in which the noise is the identity, the excess is the part of the eigenvalues above 1.
        for e in self.excesses:
            within = inverse @ e.covariance[np.ix_(seen, seen)] @ inverse.T
            values, vectors = np.linalg.eigh(0.5 * (within + within.T) - np.eye(seen.size))
            half = root @ (vectors * np.sqrt(np.maximum(values, 0.0)))
            total[np.ix_(seen, seen)] += half @ half.T
        return total


class Comparison:
    """Comparison of the scatter between parts of the records with the scatter that noise explains.

    Parameters
    ----------
    records : sequence of RecordParts
    information : (n, n)
        J^T J of all records, priors included.
    noise : (n, n)
        Covariance by noise, zero for coordinates that are not estimated.
    counted : (n,) of bool
        Coordinates that are estimated.
    """

    # Internally every coordinate is scaled to unit information: coordinates of very different units stay comparable.

    def __init__(
        self, records: Sequence[RecordParts], information: FloatArray, noise: FloatArray, counted: BoolArray
    ) -> None:
        size = np.sqrt(np.diag(information))
        self.noise, self.scale = noise, np.zeros((len(noise), int(counted.sum())))
        self.scale[counted] = np.diag(1.0 / size[counted])
        self.names = [r.name for r in records]
        self.stretches = [self._scale_parts(r.stretches) for r in records]
        self.phases = [None if r.phases is None else self._scale_parts(r.phases) for r in records]
        self.information = self.scale.T @ information @ self.scale
        self.inverse = _inverse(self.information)
        own = noise[np.ix_(counted, counted)] * np.outer(size[counted], size[counted])
        self.metric = self.inverse @ _inverse(own) @ self.inverse
        self.whitened = all(r.whitened for r in records)

    def _scale_parts(self, parts: Parts) -> Parts:
        return Parts(parts.scores @ self.scale, self.scale.T @ parts.information @ self.scale)

    @property
    def consistency(self) -> Consistency:
        """Scatter of each kind of parts, and the record that scatters most where they disagree."""
        records = [s.merge(1) for s in self.stretches]
        found = Consistency(
            phase=self._scatter([p for p in self.phases if p is not None]),
            record=self._scatter(records) if len(records) > 1 else None,
            time=self._scatter(self.stretches),
        )
        return found if found.agrees else replace(found, contested_record=self._contested_record())

    @property
    def error(self) -> ModelError:
        """Covariance by noise and by the scatter of the parts beyond noise."""
        count = len(self.names)
        phases = [p for p in self.phases if p is not None]
        quarters = _concatenate([s.merge(ERRORS.quarters) for s in self.stretches])
        found = [self._excess(jackknife_covariance(quarters, self.information), ERRORS.quarters * count - 1)]
        if phases:
            found.append(
                self._excess(
                    clustered_covariance(_concatenate(phases).scores, self.inverse), ERRORS.phases_a_record * count
                )
            )
        if count > 1:
            records = _concatenate([s.merge(1) for s in self.stretches])
            found.append(self._excess(jackknife_covariance(records, self.information), count - 1))
        return ModelError(self.noise, tuple(found))

    def error_for(self, consistency: Consistency) -> ModelError:
        """Return the covariance by noise alone where the parts agree, else the one that includes their scatter."""
        return ModelError(self.noise) if consistency.agrees else self.error

    def _excess(self, covariance: FloatArray, dof: float) -> Excess:
        return Excess(self.scale @ covariance @ self.scale.T, dof)

    def _scatter(self, parts: Sequence[Parts]) -> Scatter | None:
        """Return the scatter of some parts, None where there are fewer than two."""
        every = _concatenate(parts) if parts else None
        if every is None or every.size < 2 or not self.information.size:
            return None
        n, groups = len(self.information), every.size
        square = groups / (groups - 1) * float(self._distances(every).sum()) / n
        shares = self.metric @ every.information
        expected = float(np.trace(shares, axis1=1, axis2=2).sum()) / n
        spread = 2.0 * float(np.einsum("gij,gji->", shares, shares)) / n**2
        z = (square - expected) / np.sqrt(spread)
        ratio = float(np.sqrt(square))
        return Scatter(ratio=ratio, z=float(z), clusters=groups, by_ratio=None if self.whitened else ERRORS.ratio)

    def _distances(self, parts: Parts) -> FloatArray:
        """Return the squared distance of each part's score from zero, (G,), in units of its scatter by noise."""
        return np.asarray(np.einsum("gi,ij,gj->g", parts.scores, self.metric, parts.scores), dtype=np.float64)

    def _contested_record(self) -> str:
        """Return the record whose parts exceed the scatter expected from noise by the most."""
        each = [s if p is None else p for s, p in zip(self.stretches, self.phases, strict=True)]
        beyond = [
            float(self._distances(p).sum() - np.trace(self.metric @ p.information, axis1=1, axis2=2).sum())
            for p in each
        ]
        return self.names[int(np.argmax(beyond))]


def clustered_covariance(scores: FloatArray, inverse: FloatArray) -> FloatArray:
    """Return the cluster-robust covariance of an estimate, (n, n).

    Parameters
    ----------
    scores : (G, n)
        Score of each cluster.
    inverse : (n, n)
        (J^T J)^-1.
    """
    groups = len(scores)
    off = (scores - scores.mean(axis=0)) @ inverse
    return np.asarray(groups / max(groups - 1, 1) * off.T @ off, dtype=np.float64)


def jackknife_covariance(parts: Parts, information: FloatArray) -> FloatArray:
    """Return the covariance of an estimate by leaving out each part, one Newton step each, (n, n)."""
    # More than the whole information, so that a direction known to one part alone does not make this singular.
    without = ERRORS.jackknife_ridge * information - parts.information
    steps = np.linalg.solve(without, parts.scores[:, :, np.newaxis])[:, :, 0]
    off = steps - steps.mean(axis=0)
    return np.asarray((parts.size - 1) / parts.size * off.T @ off, dtype=np.float64)


def diagonal(maps: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return the variances of linear functions of the coordinates, (k,)."""
    return np.asarray(np.diag(maps @ covariance @ maps.T), dtype=np.float64)


def _concatenate(parts: Sequence[Parts]) -> Parts:
    return Parts(np.concatenate([p.scores for p in parts]), np.concatenate([p.information for p in parts]))


def _inverse(matrix: FloatArray) -> FloatArray:
    """Return the pseudo-inverse of a positive semidefinite matrix, (n, n); rounding eigenvalues count as zero."""
    values, vectors = np.linalg.eigh(matrix)
    seen = values > ROUNDING * values[-1]
    return np.asarray((vectors[:, seen] / values[seen]) @ vectors[:, seen].T, dtype=np.float64)


def _square_root(covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return L with L L^T the covariance, (n, n), and its inverse; eigenvalues are at least at the rounding level."""
    size = np.sqrt(np.diag(covariance))
    values, vectors = np.linalg.eigh(covariance / np.outer(size, size))
    values = np.sqrt(np.maximum(values, ROUNDING * values[-1]))
    return (size[:, np.newaxis] * vectors) * values, (vectors / values).T / size


def compare_parts(problem: Problem, q: FloatArray, windows: Windows) -> Comparison:
    """Compare the records' parts at a point, over the coordinates that are visible and not on a bound."""
    triangle = problem.joint(q, windows)
    counted = ~problem.coordinates.on_bound(q) & (np.linalg.norm(triangle.jacobian, axis=0) > 0.0)
    found = scores(problem, q, windows)
    noise = covariances(triangle, found.variance, counted).robust
    return Comparison(found.parts, triangle.jacobian.T @ triangle.jacobian, noise, counted)


def deviations_from_null(problem: Problem, q: FloatArray, windows: Windows, one: Disturbance) -> FloatArray:
    """Return the distance of each parameter of a disturbance from its null value, (k,) in standard errors.

    A parameter that replaces a free one of the mechanism has that one's value as its null value. Parameters on a bound
    are left out.
    """
    compared, at = compare_parts(problem, q, windows), problem.coordinates
    counted = np.any(compared.scale != 0.0, axis=1)
    names, slopes = at.value_slopes(q)
    slope, values = dict(zip(names, slopes, strict=True)), at.values(q)
    own = [p for p in one.parameters if counted[at.names.index(p.name)]]
    off = np.array([values[p.name] - values.get(p.replaces, p.value) for p in own])
    maps = np.array([slope[p.name] - slope.get(p.replaces, 0.0) for p in own]).reshape(len(own), problem.size)
    variance, _ = compared.error_for(compared.consistency).variances(maps)
    return np.asarray(np.abs(off) / np.sqrt(np.maximum(variance, 1e-300)), dtype=np.float64)
