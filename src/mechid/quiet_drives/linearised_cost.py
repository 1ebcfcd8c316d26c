"""Cost of a table whose lines are linear in its coefficients, minimised within the limits by an interior point.

Linear lines make the design part a quadratic form and each squared level of the range another one. Both are formed once
a linearisation, so that the many Newton steps need neither a simulation nor the lines. Peak, levels and fundamental
stay within their limits by logarithmic barriers: a penalty of the excess has a kink on which Newton's method stops, and
the nominal table stands on its peak.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.quiet_drives.periodic_torque import TorqueLines
from mechid.quiet_drives.settings import QUIET
from mechid.quiet_drives.table_basis import fundamental
from mechid.quiet_drives.table_cost import TableCost, excess_of


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
        r, J = cost.design_residuals(found, table, changes)
        self.design = _Quadratic(float(r @ r), J.T @ r, J.T @ J)
        # Squared relative levels of the range.
        ranges = [(place, lines) for place, lines in zip(cost.places, found, strict=True) if not place.weight]
        self.levels = [_squared_level(lines.with_columns(len(changes)), place.nominal.level) for place, lines in ranges]
        self.limit_weights = [place.limit_weight for place, _ in ranges]
        # A level that simulation found beyond its limit must not rise further.
        self.most = [max(QUIET.allowed_rise**2, QUIET.slack * level.value) for level in self.levels]
        self.pulls = [
            QUIET.pull if level.value <= QUIET.allowed_rise**2 else QUIET.broken_pull for level in self.levels
        ]
        self.values, self.by_step = table.ravel(), changes.reshape(len(changes), table.size).T
        self.turning = float(fundamental(table[None])[0])
        self.turning_by_step = fundamental(changes)
        # At least a little room, so that a table on its limit can be the start.
        self.least_turning = min(cost.least_fundamental, self.turning - (QUIET.slack - 1.0))
        # A table from elsewhere may stand beyond; one of the search before never does.
        self.peak = max(cost.peak * QUIET.slack, QUIET.inside * float(np.abs(table).max()))

    def minimise(self, damping: float) -> FloatArray:
        """Return the step, (m,), of least cost plus a proximal term of a relative damping, within the limits."""
        step = np.zeros(self.design.g.size)
        A = self.design.A + sum(pull**2 * level.A for pull, level in zip(self.pulls, self.levels, strict=True))
        ridge = QUIET.ridge * np.trace(A) / len(A)
        # The proximal term in the coefficients' own sensitivities, so that the damping has no unit.
        near = damping * (np.diag(A) + ridge) + ridge
        barrier = QUIET.first_barrier * self.design.value
        while barrier > QUIET.last_barrier * self.design.value:
            step = self._centre(step, near, barrier)
            barrier *= QUIET.barrier_ratio
        return step

    def smooth_part(self, range_weight: float) -> tuple[FloatArray, FloatArray]:
        """Return A (m, m) and g (m,) of the design part plus the squared levels of the range times a squared weight.

        The levels stand in place of their limits: a limit that a table keeps has no slope, and a move along it would
        break it unnoticed.
        """
        parts = [(1.0, self.design), *((range_weight**2, level) for level in self.levels)]
        A = sum((weight * part.A for weight, part in parts), np.zeros_like(self.design.A))
        return A, sum((weight * part.g for weight, part in parts), np.zeros_like(self.design.g))

    def predict(self, step: FloatArray) -> float:
        """Return the cost of a step, (m,), with linear lines and the excess over the allowed levels, without peak."""
        ratios = [max(level.at(step), 0.0) ** 0.5 for level in self.levels]
        excess = [weight * excess_of(ratio)[0] for weight, ratio in zip(self.limit_weights, ratios, strict=True)]
        return self.design.at(step) + float(np.sum(np.square(excess)) + QUIET.pull**2 * np.sum(np.square(ratios)))

    def _centre(self, step: FloatArray, near: FloatArray, barrier: float) -> FloatArray:
        """Return the step of least cost with a barrier of a weight, by damped Newton steps."""
        value, g, H = self._at(step, near, barrier)
        for _ in range(QUIET.newton_steps):
            direction = -np.linalg.solve(H, g)
            slope = float(g @ direction)
            if -slope < QUIET.newton_converged * value:
                break
            length = 1.0
            # Outside the limits the value is infinite, so that the search comes back inside.
            while (tried := self._value(step + length * direction, near, barrier)) > value + 0.1 * length * slope:
                length *= 0.5
                if length < QUIET.shortest:
                    return step
            step, value = step + length * direction, tried
            _, g, H = self._at(step, near, barrier)
        return step

    def _value(self, c: FloatArray, near: FloatArray, barrier: float) -> float:
        inside = self._room(c)
        if min(float(room.min(initial=np.inf)) for room in inside) <= 0.0:
            return float("inf")
        pulled = sum(pull**2 * level.at(c) for pull, level in zip(self.pulls, self.levels, strict=True))
        return float(
            self.design.at(c) + pulled + near @ c**2 - barrier * sum(float(np.log(room).sum()) for room in inside)
        )

    def _room(self, c: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the room to its limit of each table value, of each squared level, and of the fundamental."""
        values = self.values + self.by_step @ c
        levels = [1.0 - level.at(c) / most for level, most in zip(self.levels, self.most, strict=True)]
        turning = np.array([self.turning + self.turning_by_step @ c - self.least_turning])
        return 1.0 - (values / self.peak) ** 2, np.array(levels, dtype=np.float64), turning

    def _at(self, c: FloatArray, near: FloatArray, barrier: float) -> tuple[float, FloatArray, FloatArray]:
        """Return value, gradient and Hessian of the cost with a barrier at a step."""
        room, levels, turning = self._room(c)
        values = (self.values + self.by_step @ c) / self.peak
        g = 2.0 * (self.design.g + self.design.A @ c + near * c)
        H = 2.0 * (self.design.A + np.diag(near))
        # -log(1 - x^2) has the derivatives 2 x / (1 - x^2) and 2 (1 + x^2) / (1 - x^2)^2.
        g = g + barrier / self.peak * (self.by_step.T @ (2.0 * values / room))
        bent = 2.0 * (1.0 + values**2) / room**2 * barrier / self.peak**2
        H = H + (self.by_step.T * bent) @ self.by_step
        for level, most, left, pull in zip(self.levels, self.most, levels, self.pulls, strict=True):
            slope, weight = 2.0 * (level.g + level.A @ c), pull**2 + barrier / (most * left)
            g = g + weight * slope
            H = H + 2.0 * weight * level.A + barrier / (most * left) ** 2 * np.outer(slope, slope)
        own = self.turning_by_step / turning[0]
        return self._value(c, near, barrier), g - barrier * own, H + barrier * np.outer(own, own)


def _squared_level(lines: TorqueLines, nominal: float) -> _Quadratic:
    """Return the squared level relative to that of the nominal table."""
    scale = 0.5 / nominal**2
    conjugate = np.conj(lines.slopes.T)
    A = scale * np.real(conjugate @ lines.slopes)
    value = scale * float(np.sum(np.abs(lines.values) ** 2))
    return _Quadratic(value, scale * np.real(conjugate @ lines.values), A)
