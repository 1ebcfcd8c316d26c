"""Response of a mode with a rate profile: torque and line of sight over time, windowed RMS, and pointing indices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.budgets.discrepancy import Discrepancy
from mechid.budgets.indices import Index
from mechid.budgets.line_of_sight import ErrorFunction
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.pointing_error import PointingError, Sampled, phases
from mechid.budgets.settings import LEVEL, MOTION
from mechid.budgets.steady_state import simulate_torque
from mechid.errors import UsageError
from mechid.plant.mechanism import Mechanism
from mechid.signal.power import windowed_rms
from mechid.simulation.simulator import Simulator, TimeBase
from mechid.structure import Structure
from mechid.structure.in_time import line_of_sight_over_time


@dataclass(frozen=True, eq=False)
class ProfileResponse:
    """Torque and line of sight during a profile that starts at rest.

    Attributes
    ----------
    axes : tuple of str, (m,)
    torque : (N,)
        N m, at `sample_rate_hz`.
    sample_rate_hz : float
    series : (M, m)
        Line of sight, rad, every `thinning`-th sample.
    slopes : (p, M, m)
        Its derivative with respect to the requested parameters.
    thinning : int
    window_s : float
        Window of the RMS.
    """

    axes: tuple[str, ...]
    torque: FloatArray
    sample_rate_hz: float
    series: FloatArray
    slopes: FloatArray
    thinning: int
    window_s: float

    @property
    def columns(self) -> int:
        """Number of parameters with a derivative."""
        return int(self.slopes.shape[0])

    @property
    def series_rate_hz(self) -> float:
        """Sample rate of the line of sight."""
        return self.sample_rate_hz / self.thinning

    @property
    def starts(self) -> IntArray:
        """First sample of each window, (w,)."""
        last = len(self.series) - self._window_samples
        return np.unique(np.linspace(0, last, min(LEVEL.windows, last + 1)).astype(np.int64))

    @property
    def window_times_s(self) -> FloatArray:
        """Centre of each window, (w,) s from the start."""
        return np.asarray((self.starts + 0.5 * self._window_samples) / self.series_rate_hz, dtype=np.float64)

    @property
    def _window_samples(self) -> int:
        return min(max(round(self.window_s * self.series_rate_hz), 2), len(self.series))

    def windowed_rms(self) -> FloatArray:
        """Return the RMS about the mean in each window along each line of sight, (w, m) rad."""
        columns = [windowed_rms(column, self.series_rate_hz, self.window_s)[self.starts] for column in self.series.T]
        return np.column_stack(columns)

    def windowed_torque_rms(self) -> FloatArray:
        """Return the RMS of the torque about its mean in each window, (w,) N m."""
        rms = windowed_rms(self.torque, self.sample_rate_hz, self.window_s)
        return np.asarray(rms[np.minimum(self.starts * self.thinning, rms.size - 1)], dtype=np.float64)

    def windowed_draws(self, by: FloatArray) -> FloatArray:
        """Return the RMS in each window for deviations of the parameters (k, p), (k, w, m) rad."""
        n, out = self._window_samples, np.empty((len(by), self.starts.size, len(self.axes)))
        ones = np.column_stack([np.ones(len(by)), by])
        for axis in range(len(self.axes)):
            columns = np.column_stack([self.series[:, axis], self.slopes[:, :, axis].T])
            for j, start in enumerate(self.starts):
                part = columns[start : start + n]
                part = part - part.mean(axis=0)
                # The RMS is a quadratic form of the deviations: one Gram matrix per window serves all draws.
                square = np.einsum("kp,pq,kq->k", ones, part.T @ part / n, ones)
                out[:, j, axis] = np.sqrt(np.maximum(square, 0.0))
        return out

    def rms(self) -> FloatArray:
        """Return the largest windowed RMS along each line of sight, (m,) rad."""
        return np.asarray(self.windowed_rms().max(axis=0), dtype=np.float64)

    def error_under(self, index: Index) -> ErrorFunction:
        """Return the error as a function of the parameters' deviations, (p,), at instants spread over the profile.

        Raises
        ------
        UsageError
            The index needs more time than the profile takes.
        """
        base = _index_values(index, self.series, self.series_rate_hz)
        slopes = np.array([_index_values(index, slope, self.series_rate_hz) for slope in self.slopes])

        def error_at(by: FloatArray) -> PointingError:
            values = base + np.tensordot(by, slopes, axes=1) if by.any() else base
            return PointingError(np.zeros(values.shape[1]), (Sampled(values),))

        return error_at

    def draw_discrepancy(self, discrepancy: Discrepancy, rng: np.random.Generator) -> ProfileResponse:
        """Return a draw scaled as a whole by the model discrepancy."""
        factor = 1.0 + discrepancy.overall * float(rng.normal())
        return replace(self, series=factor * self.series, slopes=self.slopes[:0])

    def with_residual(self, rng: np.random.Generator) -> ProfileResponse:
        """Return itself: the model discrepancy covers the unmodelled torque of a profile."""
        del rng
        return self

    def without_residual(self) -> ProfileResponse:
        """Return itself."""
        return self

    def with_side(self, rng: np.random.Generator) -> ProfileResponse:
        """Return itself: the other components are known at steady rates only."""
        del rng
        return self


def run_profile(
    mechanism: Mechanism, mode: OperatingMode, names: Sequence[str], substeps: int, structure: Structure
) -> ProfileResponse:
    """Return the line-of-sight response to a mode with a profile, from rest.

    Raises
    ------
    FitError
        The mechanism diverged.
    """
    base = TimeBase(MOTION.sample_rate_hz, round(mode.duration_s * MOTION.sample_rate_hz) + 1)
    simulator = Simulator(mechanism.plant, mode.command, base, capacity=len(names) + len(mechanism.plant.states))
    y, J = simulate_torque(simulator, mechanism, names, substeps)
    # The line of sight is band-limited by `highest_hz`; the torque, which jumps, is not thinned.
    thinning = max(1, int(MOTION.sample_rate_hz / (LEVEL.samples_a_period * mode.highest_hz)))
    columns = np.hstack([y, J])
    moved = np.array(
        [
            axis[::thinning].T
            for axis in line_of_sight_over_time(structure, columns, MOTION.sample_rate_hz, mode.highest_hz)
        ]
    )
    return ProfileResponse(
        structure.line_of_sight,
        y[:, 0],
        MOTION.sample_rate_hz,
        np.ascontiguousarray(moved[:, 0].T),
        np.ascontiguousarray(np.moveaxis(moved[:, 1:], 0, -1)),
        thinning,
        mode.rms_window_s,
    )


def _index_values(index: Index, series: FloatArray, sample_rate_hz: float) -> FloatArray:
    """Return an index of a series (M, m) at `LEVEL.points` instants, spread over the series and the window, (n, m)."""
    last = len(series) - index.samples(sample_rate_hz)
    if last < 0:
        took, needs = len(series) / sample_rate_hz, index.longest_s
        raise UsageError(f"{index.kind} needs {needs:.6g} s, the profile takes {took:.6g} s; lengthen the profile")
    place, position = phases(2, LEVEL.points)
    return index.in_time(series, sample_rate_hz, (place * (last + 1)).astype(np.int64), position)
