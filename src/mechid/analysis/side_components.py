"""Forces and moments besides the drive torque: lines at orders of the step rate, with amplitude and phase.

The tracking is that of the residual torque (`residual_emission`): in windows of equal travel the sines of all orders
are fitted jointly, here to the drive torque and all components. The remainder gives the amplitude that noise alone
would produce, and the correlation of the noise between channels. The phase of a component is relative to the line of
the drive torque at the same order and window; over several windows it is the phase of their cross-spectrum (estimator
H1, Bendat and Piersol, Random Data, 4th ed., 6.1).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import fdtri, gamma

from mechid.analysis.hum_in_residual import remove_hum
from mechid.analysis.order_tracking import TravelWindow
from mechid.analysis.residual_emission import TRACKED, density_around, tracked_windows
from mechid.analysis.settings import ORDER
from mechid.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from mechid.signal import order_amplitudes, order_signal
from mechid.signal.series import Series
from mechid.signal.window import hann


@dataclass(frozen=True, kw_only=True, eq=False)
class SideAtRate:
    """Lines of the drive torque and the components at one rate.

    Attributes
    ----------
    rate : float
        Magnitude in full steps/s.
    windows : int
    duration_s : float
        Total duration of the windows.
    power : (K, c, c) complex
        Mean over the windows of a a^H, with the amplitudes a at an order of `TRACKED`, the drive torque first, in N m
        and N; NaN if the record does not reach or resolve the order.
    noise : (K, c, c) complex
        The same matrix expected from the noise between the lines alone, in one window.
    """

    rate: float
    windows: int
    duration_s: float
    power: ComplexArray
    noise: ComplexArray

    @property
    def amplitude(self) -> FloatArray:
        """Amplitude of each line without noise, root mean square over the windows, (K, c); the drive torque first."""
        left = np.diagonal(self.power - self.noise, axis1=1, axis2=2).real
        return np.asarray(np.sqrt(np.maximum(left, 0.0)))


@dataclass(frozen=True, kw_only=True, eq=False)
class SideLines:
    """Amplitudes and phases of the lines at one rate, with their errors.

    Attributes
    ----------
    amplitude : (K, s)
        Amplitude of each component at `TRACKED` without noise, in N or N m; 0 if noise explains it.
    phase : (K, s)
        Phase lead over the line of the drive torque in rad.
    covariance : (K, s, s) complex
        Covariance of the errors, E[e e^H]; increased if the windows scatter more than noise explains.
    turn : (K,)
        Common standard error of all phases in rad, due to the line of the drive torque.
    heard : (K, s)
        Whether the line exceeds noise.
    known : (K, s)
        Whether its phase to the drive torque is known.
    """

    amplitude: FloatArray
    phase: FloatArray
    covariance: ComplexArray
    turn: FloatArray
    heard: BoolArray
    known: BoolArray

    @property
    def lines(self) -> ComplexArray:
        """Complex amplitude relative to the phase of the drive torque, (K, s)."""
        return np.asarray(self.amplitude * np.exp(1j * self.phase))

    @property
    def sigma(self) -> FloatArray:
        """Standard error of each amplitude, (K, s)."""
        return np.asarray(np.sqrt(0.5 * np.diagonal(self.covariance, axis1=1, axis2=2).real))

    @property
    def phase_sigma(self) -> FloatArray:
        """Standard error of each phase, (K, s) rad; infinite if there is no line."""
        with np.errstate(divide="ignore", invalid="ignore"):
            own = np.where(self.amplitude > 0.0, self.sigma / self.amplitude, np.inf)
        return np.asarray(np.hypot(own, self.turn[:, None]))


def side_components(
    signals: Sequence[Series], travel: Series, sample_rate_hz: float, mains_hz: float | None = None
) -> tuple[SideAtRate, ...]:
    """Compute the lines of all signals by ascending rate; empty if the command travels too little.

    Multiples of the mains frequency are removed, as `mechid.analysis.residual_emission.residual_emission` does.

    Parameters
    ----------
    signals : sequence of c Series of N samples
        The drive torque in N m, then the components in N or N m, each without offset and drift.
    travel : Series of N samples
        Full steps travelled at each sample, non-decreasing.
    sample_rate_hz : float
    mains_hz : float or None
        Frequency in Hz of the grid whose hum is in the records.
    """
    hidden: frozenset[float] = frozenset()
    if mains_hz:
        # Cross-powers need an order in every signal: one that the mains hide in one signal is left out in all.
        each = [remove_hum(signal, travel, sample_rate_hz, mains_hz, TRACKED) for signal in signals]
        signals, hidden = [signal for signal, _ in each], hidden.union(*(own for _, own in each))
    found: dict[int, list[SideAtRate]] = {}
    for key, window, orders in tracked_windows(travel, sample_rate_hz):
        together = np.column_stack([window.of(signal) for signal in signals])
        found.setdefault(key, []).append(_track_window(window, together, orders, hidden))
    return tuple(pool_measurements(found[key]) for key in sorted(found))


def pool_measurements(cells: Sequence[SideAtRate]) -> SideAtRate:
    """Average several measurements at one rate, weighted by their windows."""
    windows = np.array([cell.windows for cell in cells])
    return SideAtRate(
        rate=float(np.average([cell.rate for cell in cells], weights=windows)),
        windows=int(windows.sum()),
        duration_s=sum(cell.duration_s for cell in cells),
        power=_mean(np.array([cell.power for cell in cells]), windows),
        noise=_mean(np.array([cell.noise for cell in cells]), windows),
    )


def side_lines(at: SideAtRate) -> SideLines:
    """Estimate amplitudes and phases of the components at one rate, with their errors."""
    n, power, noise = at.windows, np.nan_to_num(at.power), np.nan_to_num(at.noise)
    own, alone = (np.diagonal(matrix, axis1=1, axis2=2).real for matrix in (power, noise))
    heard = (alone > 0.0) & (own > least_power(n, own.shape[1] - 1) * alone)
    left = np.where(heard, np.maximum(own - alone, 0.0), 0.0)
    cross, square = power[:, 1:, 0] - noise[:, 1:, 0], left[:, 1:] * left[:, :1]
    coherence = np.divide(np.abs(cross) ** 2, square, out=np.zeros(square.shape), where=square > 0.0)
    with np.errstate(divide="ignore"):
        # The phase error of the drive torque rotates all components equally.
        turn = np.sqrt(0.5 * alone[:, 0] / (n * left[:, 0]))
    in_phase = heard[:, 1:] & (coherence > least_coherence(n))
    lines = SideLines(
        amplitude=np.sqrt(left[:, 1:]),
        phase=np.angle(cross),
        covariance=_errors(at, coherence, in_phase),
        turn=turn,
        heard=heard[:, 1:],
        known=in_phase,
    )
    return replace(lines, known=in_phase & (lines.phase_sigma < 1.0 / ORDER.resolved))


def least_power(windows: int, components: int) -> float:
    """Return the ratio by which the mean power of a line has to exceed that of noise to be significant.

    Both are sums of squares, so their ratio has an F distribution: the line contributes 2 terms per window, the noise
    those of the surrounding bins.
    """
    alarm = ORDER.false_alarm / (len(TRACKED) * max(components, 1))
    return float(fdtri(2 * windows, 2 * windows * ORDER.bins / ORDER.hann_bins, 1.0 - alarm))


def least_coherence(windows: int) -> float:
    """Return the coherence with the drive torque above which the phase of a line counts as known.

    Random phases of the windows lie within a ball of radius r about their mean with a probability given by the volume
    of the ball. With their mean square s = r^2 / n the coherence is 1 - s. A single window determines no phase.

    Examples
    --------
    >>> [round(least_coherence(n), 4) for n in (2, 3, 5, 20)]
    [0.9998, 0.9758, 0.7623, 0.5]
    """
    d = windows - 1
    # A single window always has a coherence of 1.
    if d < 1:
        return float("inf")
    ball = np.pi ** (0.5 * d) / gamma(0.5 * d + 1.0) * np.sqrt(windows)
    scatter = (
        (ORDER.phase_by_chance * (2.0 * np.pi) ** d / ball) ** (2.0 / d) / windows if d < ORDER.many_windows else 1.0
    )
    return float(max(ORDER.coherent, 1.0 - scatter))


def _errors(at: SideAtRate, coherence: FloatArray, in_phase: BoolArray) -> ComplexArray:
    """Return the covariance of the errors: that of noise, increased for lines in phase with a larger scatter.

    Scatter due to the noise of the drive torque is excluded, since it rotates all lines equally.
    """
    n, power, noise = at.windows, np.nan_to_num(at.power), np.nan_to_num(at.noise)
    own, alone = (np.diagonal(matrix, axis1=1, axis2=2).real for matrix in (power, noise))
    line = np.maximum(own - alone, 0.0)[:, 1:] * np.minimum(coherence, 1.0)
    drive = np.divide(alone[:, :1], own[:, :1], out=np.ones((len(own), 1)), where=own[:, :1] > 0.0)
    scatter = (own[:, 1:] - line) * n / max(n - 1, 1) - line * drive
    ratio = np.divide(scatter, alone[:, 1:], out=np.ones(scatter.shape), where=in_phase & (alone[:, 1:] > 0.0))
    raised = np.sqrt(np.maximum(ratio, 1.0))
    return np.asarray(noise[:, 1:, 1:] * raised[:, :, None] * raised[:, None, :] / n)


def _track_window(
    window: TravelWindow, together: FloatArray, orders: list[float], hidden: Collection[float]
) -> SideAtRate:
    amplitudes, _ = order_amplitudes(together, window.position, orders)
    fitted = [order_signal(column, window.position, orders) for column in amplitudes.T]
    between = together - together.mean(axis=0) - np.column_stack(fitted)
    duration_s, tracked = len(together) / window.sample_rate_hz, np.isin(TRACKED, orders)
    shape = (len(TRACKED), together.shape[1], together.shape[1])
    power, noise = (np.full(shape, np.nan, dtype=np.complex128) for _ in range(2))
    power[tracked] = amplitudes[:, :, None] * amplitudes[:, None, :].conj()
    noise[tracked] = 2.0 / duration_s * _cross_density(between, window.sample_rate_hz, window.rate * np.array(orders))
    power[np.isin(TRACKED, [*hidden])] = np.nan
    return SideAtRate(rate=window.rate, windows=1, duration_s=duration_s, power=power, noise=noise)


def _cross_density(between: FloatArray, sample_rate_hz: float, lines_hz: FloatArray) -> ComplexArray:
    """Return the one-sided mean cross-spectral density around each line, (k, c, c), E[x_i x_j*]."""
    n, channels = between.shape
    weights = hann(n)
    spectra = np.fft.rfft((between - between.mean(axis=0)) * weights[:, None], axis=0).T
    scale = 2.0 / (sample_rate_hz * np.sum(weights**2))
    frequency = np.asarray(np.fft.rfftfreq(n, 1.0 / sample_rate_hz), dtype=np.float64)
    out = np.empty((lines_hz.size, channels, channels), dtype=np.complex128)
    for i in range(channels):
        # The other half follows from the matrices being Hermitian.
        for j in range(i + 1):
            out[:, i, j] = density_around(frequency, scale * spectra[i] * spectra[j].conj(), lines_hz)
            out[:, j, i] = out[:, i, j].conj()
    return out


def _mean(matrices: ComplexArray, windows: IntArray) -> ComplexArray:
    """Return the mean of each entry over finite values, weighted by windows; NaN if there are none."""
    known = np.isfinite(matrices)
    weights = known * windows.reshape(-1, 1, 1, 1)
    total = weights.sum(axis=0)
    mean = np.where(known, matrices, 0.0) * weights
    return np.where(total > 0, mean.sum(axis=0) / np.maximum(total, 1), np.nan)
