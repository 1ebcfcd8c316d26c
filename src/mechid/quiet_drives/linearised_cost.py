"""Cost of a table whose lines are linear in its coefficients, with the kinked limits kept as they are.

Linear lines make the design part a quadratic form and each squared level of the range another one. Both are formed once
a linearisation, so that its many small steps need neither a simulation nor the lines.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.quiet_drives.periodic_torque import TorqueLines
from mechid.quiet_drives.settings import QUIET
from mechid.quiet_drives.table_cost import TableCost, excess_of, peak_part


@dataclass(frozen=True, eq=False)
class _Quadratic:
    """The form value + 2 g c + c A c of a step c."""

    value: float
    g: FloatArray
    A: FloatArray

    def at(self, c: FloatArray) -> float:
        return float(self.value + 2.0 * self.g @ c + c @ self.A @ c)


class LinearisedCost:
    """Cost of a step of the coefficients from a table.

    Parameters
    ----------
    cost : TableCost
    found : sequence of TorqueLines
        Lines at each place with slopes along `changes`.
    table : (4 n, 2)
    changes : (m, 4 n, 2)
    """

    def __init__(self, cost: TableCost, found: Sequence[TorqueLines], table: FloatArray, changes: FloatArray) -> None:
        self.cost, self.table, self.changes = cost, table, changes
        r, J = cost.design_residuals(found, table, changes)
        self.design = _Quadratic(float(r @ r), J.T @ r, J.T @ J)
        self.levels = [
            (place, _squared_level(lines.with_columns(len(changes)), place.nominal.level))
            for place, lines in zip(cost.places, found, strict=True)
            if not place.weight
        ]

    def minimise(self, damping: float) -> FloatArray:
        """Return the step, (m,), of least cost plus a proximal term of a relative damping."""
        step, inner = np.zeros(len(self.changes)), QUIET.damping
        value, g, A = self._at(step)
        ridge = QUIET.ridge * np.trace(A) / len(A)
        # The proximal term in the coefficients' own sensitivities, so that the damping has no unit.
        near = damping * (np.diag(A) + ridge)
        for _ in range(QUIET.model_steps):
            own = np.diag(near + inner * np.diag(A) + ridge)
            further = step - np.linalg.solve(A + own, g + near * step)
            tried, g_next, A_next = self._at(further)
            tried += float(near @ further**2)
            if tried >= value:
                inner *= QUIET.raised
                continue
            gained, step, value, g, A = value - tried, further, tried, g_next, A_next
            inner /= QUIET.raised
            if gained < QUIET.model_converged * value:
                break
        return step

    def _at(self, c: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Return the cost of a step, half its gradient, and its Gauss-Newton matrix."""
        value, g, A = self.design.at(c), self.design.g + self.design.A @ c, self.design.A.copy()
        moved = self.table + np.tensordot(c, self.changes, axes=1)
        over, over_slopes = peak_part(moved, self.changes, self.cost.peak)
        rows, slopes = [*over[over != 0.0]], [*over_slopes[over != 0.0]]
        for place, square in self.levels:
            ratio = float(np.sqrt(max(square.at(c), 1e-12)))
            slope = (square.g + square.A @ c) / ratio
            excess, steepness = excess_of(ratio)
            rows += [place.limit_weight * excess, QUIET.pull * ratio]
            slopes += [place.limit_weight * steepness * slope, QUIET.pull * slope]
        r, J = np.array(rows), np.array(slopes).reshape(len(rows), c.size)
        return value + float(r @ r), g + J.T @ r, A + J.T @ J


def _squared_level(lines: TorqueLines, nominal: float) -> _Quadratic:
    """Return the squared level relative to that of the nominal table."""
    scale = 0.5 / nominal**2
    conjugate = np.conj(lines.slopes.T)
    A = scale * np.real(conjugate @ lines.slopes)
    return _Quadratic(scale * float(np.sum(np.abs(lines.values) ** 2)), scale * np.real(conjugate @ lines.values), A)
