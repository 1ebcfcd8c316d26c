"""Cost of a microstep table: lines, level and roughness as a vector of residuals.

Each place is one mechanism at one rate. At a design place the residuals are the chosen orders relative to those of the
nominal table, and all lines relative to its level: a cost of the chosen orders alone lowers them and raises high
frequencies nobody weighed. At a place of the range they are the excess over the allowed level and, weakly, the level.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.quiet_drives.periodic_torque import PeriodicTorque, TorqueLines
from mechid.quiet_drives.quantity import Quantity
from mechid.quiet_drives.settings import QUIET
from mechid.quiet_drives.table_basis import roughness


@dataclass(frozen=True, eq=False)
class Place:
    """One mechanism at one rate.

    Attributes
    ----------
    torque : PeriodicTorque
    nominal : TorqueLines
        Lines of the nominal table.
    weight : float
        Weight of a design place; 0 for a place of the range.
    limit_weight : float
        Weight of the excess over the allowed level.
    """

    torque: PeriodicTorque
    nominal: TorqueLines
    weight: float
    limit_weight: float = QUIET.limit_weight


@dataclass(frozen=True, eq=False)
class TableCost:
    """Residuals of a table and their derivatives.

    Attributes
    ----------
    places : sequence of Place
    orders : tuple of float
        Chosen orders of the step rate.
    base : (4 n, 2)
        Nominal table.
    peak : float
        Largest magnitude of a value.
    least_fundamental : float
        Least fundamental of a table, relative to the nominal one.
    """

    places: Sequence[Place]
    orders: tuple[float, ...]
    base: FloatArray
    peak: float
    least_fundamental: float = 0.0

    @property
    def quantity(self) -> Quantity:
        """Quantity whose lines it weighs."""
        return self.places[0].torque.quantity

    def simulate(self, table: FloatArray, changes: FloatArray | None = None) -> list[TorqueLines] | None:
        """Return the lines at each place, with slopes along changes (m, 4 n, 2); None if the rotor loses steps."""
        found = [_lines_at(place, table, changes) for place in self.places]
        kept = [lines for lines in found if lines is not None]
        return kept if len(kept) == len(found) else None

    def residuals(
        self, found: Sequence[TorqueLines], table: FloatArray, changes: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return all residuals (r,) of simulated lines with a table, and their derivatives (r, m)."""
        parts = [self.design_residuals(found, table, changes), peak_part(table, changes, self.peak)]
        for place, lines in zip(self.places, found, strict=True):
            if not place.weight:
                parts.append(_range_part(place, lines.with_columns(len(changes))))
        return np.concatenate([part for part, _ in parts]), np.concatenate([slope for _, slope in parts])

    def design_residuals(
        self, found: Sequence[TorqueLines], table: FloatArray, changes: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the residuals that are linear in the lines and the table, and their derivatives."""
        parts = [_roughness_part(table - self.base, changes)]
        for place, lines in zip(self.places, found, strict=True):
            if place.weight:
                parts.append(self._design_part(place, lines.with_columns(len(changes))))
        return np.concatenate([part for part, _ in parts]), np.concatenate([slope for _, slope in parts])

    def value(self, found: Sequence[TorqueLines], table: FloatArray) -> float:
        """Return the sum of squared residuals of lines with a table."""
        r, _ = self.residuals(found, table, np.zeros((0, *table.shape)))
        return float(r @ r)

    def _design_part(self, place: Place, lines: TorqueLines) -> tuple[FloatArray, FloatArray]:
        nominal = np.abs(place.nominal.values)
        scale = np.full(lines.values.size, place.weight / (np.sqrt(2.0) * place.nominal.level))
        z, slope = [scale * lines.values], [scale[:, None] * lines.slopes]
        for order in self.orders:
            k, own = lines.at(order), place.nominal.at(order)
            if k is not None and own is not None:
                by = place.weight / max(float(nominal[own]), QUIET.least_line * float(nominal.max()))
                z.append(by * lines.values[k : k + 1])
                slope.append(by * lines.slopes[k : k + 1])
        flat, steep = np.concatenate(z), np.concatenate(slope)
        return np.concatenate([flat.real, flat.imag]), np.concatenate([steep.real, steep.imag])


def _lines_at(place: Place, table: FloatArray, changes: FloatArray | None) -> TorqueLines | None:
    return place.torque.lines(table) if changes is None else place.torque.lines_and_slopes(table, changes)


def excess_of(ratio: float) -> tuple[float, float]:
    """Return the excess of a relative level over the allowed one, and its derivative."""
    return max(ratio - QUIET.allowed_rise, 0.0), float(ratio > QUIET.allowed_rise)


def _range_part(place: Place, lines: TorqueLines) -> tuple[FloatArray, FloatArray]:
    ratio = lines.level / place.nominal.level
    slope = np.real(np.conj(lines.values) @ lines.slopes) / (2.0 * lines.level * place.nominal.level)
    excess, steepness = excess_of(ratio)
    r = np.array([place.limit_weight * excess, QUIET.pull * ratio])
    return r, np.array([place.limit_weight * steepness * slope, QUIET.pull * slope])


def _roughness_part(change: FloatArray, changes: FloatArray) -> tuple[FloatArray, FloatArray]:
    own = QUIET.roughness * roughness(change[None])[:, 0]
    return own, QUIET.roughness * roughness(changes)


def peak_part(table: FloatArray, changes: FloatArray, peak: float) -> tuple[FloatArray, FloatArray]:
    """Return the excess of each value over the peak limit, weighted, and its derivatives."""
    # The slack within which the search moves is no excess.
    excess = np.maximum(np.abs(table) - QUIET.slack * peak, 0.0).ravel()
    slope = np.where(excess > 0.0, np.sign(table).ravel(), 0.0)[:, None] * changes.reshape(len(changes), table.size).T
    return QUIET.peak_weight * excess, QUIET.peak_weight * slope
