"""Torque lines of the periodic motion at one rate, and their derivatives with respect to a microstep table.

The motion over one period of the equations is x' = F(x, c), c the table's coefficients. At its fixed point x* the lines
L(x, c) change by

    dL/dc = L_c + L_x (I - M)^-1 F_c,   M = F_x,

M and L_x from the kernel's forward sensitivities, which hold across stick-slip switches. The kernel takes phase values
as inputs, not parameters, so that F_c and L_c are differences of one period run again from x* with a changed table.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.orbit import Orbit, find_orbit
from mechid.budgets.period_map import PeriodMap
from mechid.command import Excitation
from mechid.errors import FitError
from mechid.plant.mechanism import Mechanism
from mechid.quiet_drives.quantity import TORQUE, Quantity
from mechid.quiet_drives.settings import QUIET
from mechid.quiet_drives.table_command import table_command
from mechid.simulation.block import State


@dataclass(frozen=True, eq=False)
class TorqueLines:
    """Lines of the torque at one rate.

    Attributes
    ----------
    orders : (n,)
        Multiples of the step rate.
    values : (n,) complex
        Peak amplitude and phase, N m, or the line of sight's root sum of squares in rad.
    slopes : (n, m) complex
        Derivatives with respect to the table's coefficients; no columns if none were asked for.
    repeats : bool
        Whether the motion repeats. If not, the values are root mean squares over several periods, without slopes.
    """

    orders: FloatArray
    values: ComplexArray
    slopes: ComplexArray
    repeats: bool

    @property
    def level(self) -> float:
        """RMS of all lines, N m or rad."""
        return float(np.sqrt(0.5 * np.sum(np.abs(self.values) ** 2)))

    def with_columns(self, columns: int) -> TorqueLines:
        """Return the lines with slopes along a number of changes: their own if they match, else zeros."""
        if self.slopes.shape[1] == columns:
            return self
        return replace(self, slopes=np.zeros((self.values.size, columns), dtype=np.complex128))

    def at(self, order: float) -> int | None:
        """Return the position of an order; None if no line has it."""
        found = np.flatnonzero(np.abs(self.orders - order) < 1e-6)
        return int(found[0]) if found.size else None


class PeriodicTorque:
    """Torque of one mechanism at one rate, with the table as variable.

    The state found for one table is the start for the next.

    Parameters
    ----------
    mechanism : Mechanism
        In flight, on a held base.
    rate : float
        Full steps/s.
    quantity : Quantity
        By which the lines are weighted.
    """

    def __init__(self, mechanism: Mechanism, rate: float, quantity: Quantity = TORQUE) -> None:
        self.mechanism, self.rate, self.quantity = mechanism, rate, quantity
        self._p = mechanism.kernel_values()
        self._x: FloatArray | None = None

    def lines(self, table: FloatArray) -> TorqueLines | None:
        """Return the lines with a table, (4 n, 2); None if the rotor loses steps or the simulation fails."""
        return self._lines(table, None)

    def lines_and_slopes(self, table: FloatArray, changes: FloatArray) -> TorqueLines | None:
        """Return the lines and their derivatives along changes of the table, (m, 4 n, 2); None as for `lines`."""
        return self._lines(table, changes)

    def _lines(self, table: FloatArray, changes: FloatArray | None) -> TorqueLines | None:
        period = self._period(table)
        try:
            orbit = self._orbit(period) if period.repeats else None
            if orbit is None:
                return self._average_periods(period, 0 if changes is None else len(changes))
            if orbit.turns:
                return None
            if changes is None:
                y, _, _ = self._one_period(period, orbit.x, np.zeros((orbit.x.size, 0)))
                return self._as_lines(period, y, np.zeros((y.size, 0)))
            return self._with_slopes(period, orbit, table, changes)
        except FitError:
            # A start that diverged must not be the start of the next table.
            self._x = None
            return None

    def _period(self, table: FloatArray) -> PeriodMap:
        command = table_command(table, self.rate)
        mode = OperatingMode(name="", command=command, rates=np.array([self.rate]), highest_hz=1.0)
        return PeriodMap(self.mechanism, mode, self.rate, (), 1)

    def _orbit(self, period: PeriodMap) -> Orbit | None:
        settle = max(round(QUIET.settle_s / period.duration_s), 1)
        for attempt in range(QUIET.attempts):
            # The orbit of a slightly different table is near enough for Newton's method without a simulation.
            if self._x is None or attempt:
                self._x = period.state_after(self._x, settle)
            found = find_orbit(period, self._x, 1)
            if found is not None:
                self._x = found.x
                return found
        return None

    def _average_periods(self, period: PeriodMap, columns: int) -> TorqueLines | None:
        """Return root mean squares of the lines over several periods of a motion that does not repeat."""
        x = period.state_after(self._x, 1)
        periods = min(max(round(QUIET.averaged_s / period.duration_s), 1), QUIET.most_averaged)
        squares, begun = [], x
        for _ in range(periods):
            y, _, end = self._one_period(period, x, np.zeros((x.size, 0)))
            squares.append(np.abs(self._as_lines(period, y, np.zeros((y.size, 0))).values) ** 2)
            own = period.repetition
            x = np.asarray(own.sign * end.x - own.turn)
        if period.turns_off(x - begun):
            return None
        root = np.sqrt(np.mean(squares, axis=0)).astype(np.complex128)
        orders = self._orders(period, root.size)
        return TorqueLines(orders, root, np.zeros((root.size, columns), dtype=np.complex128), repeats=False)

    def _with_slopes(self, period: PeriodMap, orbit: Orbit, table: FloatArray, changes: FloatArray) -> TorqueLines:
        n, sign = orbit.x.size, period.repetition.sign
        # A state that friction holds does not move with its own deviation.
        lanes = np.diag(1.0 - period.pinned_states(orbit.x))
        y, y_x, end = self._one_period(period, orbit.x, lanes)
        y_c, F_c = np.empty((y.size, len(changes))), np.empty((n, len(changes)))
        edges = period.simulator(y.size + 1, 0).excitation
        # The steps of a constant rate come one row after the other; only their values differ between tables.
        rows = np.arange(1, edges.times.size + 1) % len(table)
        for k, change in enumerate(changes):
            other = table + QUIET.change * change
            moved, _, moved_end = self._one_period(
                period, orbit.x, np.zeros((n, 0)), replace(edges, initial=other[0], values=other[rows])
            )
            y_c[:, k] = (moved - y) / QUIET.change
            F_c[:, k] = sign * (moved_end.x - end.x) / QUIET.change
        # States in their own sizes, so that neutral coordinates can be told by one tolerance.
        size = orbit.size
        scaled = (sign[:, None] * end.lanes) * size / size[:, None]
        x_c = size[:, None] * np.linalg.lstsq(np.eye(n) - scaled, F_c / size[:, None], rcond=1e-9)[0]
        return self._as_lines(period, y, y_c + y_x @ x_c)

    def _one_period(
        self, period: PeriodMap, x: FloatArray, lanes: FloatArray, edges: Excitation | None = None
    ) -> tuple[FloatArray, FloatArray, State]:
        """Return torque (N,), its derivatives with respect to the lanes (N, k), and the final state.

        `edges` replaces the voltages of the command.
        """
        count, k = period.samples, lanes.shape[1]
        simulator = period.simulator(count + 1, period.lanes)
        if edges is not None:
            simulator = replace(simulator, known_edges=edges)
        run = simulator.run(self._p, substeps=period.substeps, directions=np.zeros((self._p.size, k)))
        run.restart(State(x, lanes))
        y, y_x = np.empty(count), np.empty((count, k))
        for block in run.blocks():
            rows = slice(block.start, min(block.stop, count))
            y[rows] = block.y[: rows.stop - rows.start, 0]
            if k:
                y_x[rows] = block.jacobian[: rows.stop - rows.start, 0, :k]
        if not np.isfinite(y).all():
            raise FitError(f"at {self.rate:.6g} steps/s: {run.outcome.value}")
        return y, y_x, run.state

    def _as_lines(self, period: PeriodMap, y: FloatArray, y_c: FloatArray) -> TorqueLines:
        count = min(int(QUIET.highest_hz * period.duration_s), y.size // 2 - 1)
        spectrum = 2.0 / y.size * np.fft.rfft(np.column_stack([y, y_c]), axis=0)[1 : count + 1]
        spectrum *= self.quantity.weight(np.arange(1, count + 1) / period.duration_s)[:, None]
        return TorqueLines(self._orders(period, count), spectrum[:, 0], spectrum[:, 1:], repeats=True)

    @staticmethod
    def _orders(period: PeriodMap, count: int) -> FloatArray:
        return np.arange(1, count + 1) / period.steps
