"""Streaming reduction of [Phi r J] to its triangle, block by block, by Householder reflections.

After all blocks the rows of Phi (offset, drift: linear, projected out) are dropped. What is left is the
triangle of [r J]: the residual is (||r||, 0, ..., 0) in its basis, the Jacobian the rest. Memory does not
grow with the record, and the condition of J is not squared as by normal equations.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from types import ModuleType

import numpy as np

from mechid.arrays import FloatArray
from mechid.kernel.compiled import compiled_module


@lru_cache(maxsize=1)
def _reflections() -> ModuleType:
    """Return the compiled reflections, from the cache where they have been compiled before."""
    text = resources.files(__package__).joinpath("reflections.py").read_text(encoding="utf-8")
    name = f"reflections_{hashlib.sha256(text.encode()).hexdigest()[:24]}"
    return compiled_module(name, lambda: text, lambda made: made.absorb(np.zeros((1, 1)), np.zeros((1, 1)), 0))


def absorb(R: FloatArray, block: FloatArray, n: int) -> None:
    """Update the triangle R, (m, m), with n further rows that stand as the columns of `block`, (m, >= n).

    Raises
    ------
    UsageError
        The reflections are not compiled yet, and the cache cannot be written to.
    """
    _reflections().absorb(R, block, n)


@dataclass(frozen=True)
class Triangle:
    """The reduced least-squares problem of one or more records.

    Attributes
    ----------
    norm : float
        ||r|| after projection, in units of sigma.
    jacobian : (1 + n, n)
        In the basis in which the residual is (norm, 0, ..., 0).
    samples : int
    """

    norm: float
    jacobian: FloatArray
    samples: int

    @property
    def cost(self) -> float:
        """Sum of squares, in units of sigma squared."""
        return self.norm**2

    @property
    def fun(self) -> FloatArray:
        """The residual in the triangle's basis, (1 + n,)."""
        out = np.zeros(self.jacobian.shape[0])
        out[0] = self.norm
        return out


def finished(R: FloatArray, linear: int, samples: int) -> Triangle:
    """Drop the first `linear` rows of a triangle of [Phi r J] and fix the sign of the residual's."""
    rest = R[linear:, linear:]
    sign = -1.0 if rest[0, 0] < 0.0 else 1.0
    jacobian = rest[:, 1:].copy()
    jacobian[0] *= sign
    return Triangle(abs(float(rest[0, 0])), jacobian, samples)


def of_rows(r: FloatArray, J: FloatArray) -> Triangle:
    """Reduce residuals, (k,), and their derivatives, (k, n), that are at hand as they are."""
    R = np.zeros((J.shape[1] + 1, J.shape[1] + 1))
    absorb(R, np.ascontiguousarray(np.column_stack([r, J]).T), r.size)
    return finished(R, 0, r.size)


def combined(triangles: list[Triangle]) -> Triangle:
    """Join the triangles of independent records into one."""
    n = triangles[0].jacobian.shape[1]
    stacked = np.vstack([np.column_stack([t.fun, t.jacobian]) for t in triangles])
    R = np.zeros((n + 1, n + 1))
    absorb(R, np.ascontiguousarray(stacked.T), stacked.shape[0])
    return finished(R, 0, sum(t.samples for t in triangles))
