"""Correction of a table's response by a regularised inverse, applied to records as a filter without delay.

With the response H, made free of units by a length, the inverse is P = (H* H + lambda^2 I)^-1 H* (Tikhonov), which is
1 / H but where a singular value is small. Elements of H with standard errors s_jk change the corrected loads y by
P dH y: the error of load i from load k has the standard deviation G_ik |y_k| with

    G_ik^2 = sum_j |P_ij|^2 s_jk^2 + |(P H - I)_ik|^2.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from mechid.arrays import BoolArray, ComplexArray, FloatArray
from mechid.emissions.settings import BENCH
from mechid.emissions.table_response import SIX, TableResponse
from mechid.signal.continuation import TRAINED, continue_series
from mechid.signal.series import Series, blocks
from mechid.signal.stored_series import WritableSeries, allocate_series

LEAST_TAPS, MOST_TAPS = 64, 2**17
COUPLED = 1e-9
"""Size of an element of the inverse, relative to one, below which two components are not coupled."""
_SCALE = np.array([1.0, 1.0, 1.0, BENCH.arm_m, BENCH.arm_m, BENCH.arm_m])


@dataclass(frozen=True, kw_only=True, eq=False)
class Correction:
    """Corrected loads of a table and their standard errors.

    Parameters
    ----------
    response : TableResponse or None
        None where the loads are taken as calibrated.
    calibration_error : float
        Relative standard error of the calibration.
    band_hz : (float, float)
        Band that is declared as usable.
    """

    response: TableResponse | None
    calibration_error: float = 0.0
    band_hz: tuple[float, float] = (0.0, np.inf)
    _filters: dict[float, Mapping[tuple[int, int], FloatArray]] = field(default_factory=dict)

    @cached_property
    def grid_hz(self) -> FloatArray:
        """Frequencies at which errors are known, (n,)."""
        return np.array([0.0, 1.0]) if self.response is None else self.response.grid_hz

    @cached_property
    def _inverse(self) -> ComplexArray:
        return self.inverse(self.grid_hz)

    def inverse(self, frequency_hz: FloatArray) -> ComplexArray:
        """Return the matrices that make loads of measured loads, (n, 6, 6), in N and N m."""
        if self.response is None:
            return np.tile(np.eye(SIX, dtype=np.complex128), (frequency_hz.size, 1, 1))
        units = _SCALE[None, :] / _SCALE[:, None]
        at_rest = np.linalg.norm(self.response.at(self.grid_hz[:1])[0] * units, 2)
        h = self.response.at(frequency_hz) * units
        adjoint = np.conj(np.swapaxes(h, 1, 2))
        normal = adjoint @ h + (BENCH.regularisation * at_rest) ** 2 * np.eye(SIX)
        return np.asarray(np.linalg.solve(normal, adjoint) / units, dtype=np.complex128)

    @cached_property
    def errors(self) -> FloatArray:
        """Standard errors of each load for one of each load, G of the head, on the grid, (n, 6, 6)."""
        p = np.abs(self._inverse) ** 2
        h = np.tile(np.eye(SIX, dtype=np.complex128), (self.grid_hz.size, 1, 1))
        variance = np.zeros(h.shape, dtype=np.float64)
        if self.response is not None:
            h = self.response.at(self.grid_hz)
            variance += self.response.sigma(self.grid_hz) ** 2
        # the calibration's elements, relative to the sensitivities, ahead of the table's own response
        beside = np.sum(np.abs(h) ** 2 / _SCALE[None, :, None] ** 2, axis=1)
        variance += self.calibration_error**2 * _SCALE[None, :, None] ** 2 * beside[:, None, :]
        bias = np.abs(self._inverse @ h - np.eye(SIX)) ** 2
        return np.asarray(np.sqrt(p @ variance + bias), dtype=np.float64)

    def error_variance(self, frequency_hz: FloatArray, component: int) -> FloatArray:
        """Return the squared errors of a load for one of each load, (n, 6)."""
        own = self.errors[:, component] ** 2
        return np.stack([np.interp(frequency_hz, self.grid_hz, own[:, k]) for k in range(SIX)], axis=1)

    @cached_property
    def uncertainty(self) -> FloatArray:
        """Relative uncertainty (95 %) of each load on the grid, (n, 6), all loads being as large as each other."""
        ratio = _SCALE[None, None, :] / _SCALE[None, :, None]
        return np.asarray(BENCH.coverage * np.sqrt(np.sum((self.errors * ratio) ** 2, axis=2)), dtype=np.float64)

    @cached_property
    def supported_hz(self) -> FloatArray:
        """Lowest and highest frequency at which each component is known to 1 dB, (6, 2); an empty band at 0 if none."""
        if self.response is None:
            known = self.uncertainty[0] <= BENCH.most_error
            return np.array([[0.0, np.inf if each else 0.0] for each in known])
        return np.array([self._find_support(k) for k in range(SIX)])

    def _find_support(self, component: int) -> tuple[float, float]:
        assert self.response is not None
        low, high = self.response.coverage_hz[component]
        if np.isnan(low):
            return 0.0, 0.0
        inside = np.flatnonzero((self.grid_hz >= low) & (self.grid_hz <= high))
        beyond = inside[self.uncertainty[inside, component] > BENCH.most_error]
        if not beyond.size:
            return float(low), float(high)
        # The band ends where the limit is first exceeded, even if it holds again above a resonance.
        last = beyond[0] - 1
        return (float(low), float(self.grid_hz[last])) if last >= inside[0] else (0.0, 0.0)

    @cached_property
    def coupled(self) -> BoolArray:
        """Tell which measured load each load is made of, (6, 6)."""
        units = _SCALE[None, :] / _SCALE[:, None]
        return np.asarray(np.abs(self._inverse * units).max(axis=0) > COUPLED)

    def filter_loads(self, loads: Mapping[int, Series], sample_rate_hz: float) -> dict[int, WritableSeries]:
        """Return the corrected loads by component, N samples each.

        Parameters
        ----------
        loads : mapping of int to Series of N samples
            Measured loads by component, with all that one of them is coupled to, in N and N m.
        sample_rate_hz : float
        """
        filters = {pair: taps for pair, taps in self._filters_at(sample_rate_hz).items() if pair[0] in loads}
        size = next(iter(loads.values())).size
        half = next(iter(filters.values())).size // 2
        # Blocks of several filter lengths keep the share of samples that are transformed twice small.
        step = min(next_fast_len(8 * half, real=True), next_fast_len(size + 2 * half, real=True)) - 2 * half
        spectra = {pair: rfft(taps, step + 2 * half) for pair, taps in filters.items()}
        out = {k: allocate_series(size) for k in loads}
        for part in blocks(size, step):
            around = slice(part.start - half, part.start + step + half)
            measured = {k: rfft(_extend(series, around)) for k, series in loads.items()}
            for row, room in out.items():
                total = sum(measured[k] * spectrum for (to, k), spectrum in spectra.items() if to == row)
                # the middle tap stands at `half`, and the block begins `half` samples ahead of its part
                room[part] = irfft(total, step + 2 * half)[2 * half : 2 * half + part.stop - part.start]
        return out

    def _filters_at(self, sample_rate_hz: float) -> Mapping[tuple[int, int], FloatArray]:
        """Return the taps of each coupled pair, (2 half,), their middle at half the length."""
        if sample_rate_hz not in self._filters:
            least = sample_rate_hz / BENCH.resolution_hz
            taps = int(np.clip(2 ** int(np.ceil(np.log2(least))), LEAST_TAPS, MOST_TAPS))
            frequency = np.asarray(np.arange(taps // 2 + 1) * (sample_rate_hz / taps), dtype=np.float64)
            inverse = self.inverse(frequency)
            # Up to the end of the response, not of the usable band: a resonance that were left in the record would pass
            # the skirts of band-pass filters below it. Beyond, the loads are as measured.
            ends = [np.inf] * SIX if self.response is None else self.response.coverage_hz[:, 1]
            weight = np.stack([_fade(frequency, high) for high in ends], axis=1)
            wanted = weight[:, :, None] * inverse + (1.0 - weight)[:, :, None] * np.eye(SIX)
            own = {
                (row, k): np.roll(irfft(wanted[:, row, k], taps), taps // 2)
                for row, k in zip(*map(np.ndarray.tolist, np.nonzero(self.coupled)), strict=True)
            }
            self._filters[sample_rate_hz] = own
        return self._filters[sample_rate_hz]

    @cached_property
    def applied_hz(self) -> FloatArray:
        """Band of each component that may be judged, (6, 2): the supported one within that declared."""
        low, high = self.band_hz
        return np.stack([np.maximum(self.supported_hz[:, 0], low), np.minimum(self.supported_hz[:, 1], high)], axis=1)


def _fade(frequency_hz: FloatArray, high_hz: float) -> FloatArray:
    """Return the weight of the inverse: 1 up to the end of a response, 0 beyond `BENCH.taper` times that."""
    if not np.isfinite(high_hz):
        return np.ones(frequency_hz.size)
    beyond = (frequency_hz - high_hz) / max((BENCH.taper - 1.0) * high_hz, np.finfo(np.float64).tiny)
    return np.asarray(0.5 * (1.0 + np.cos(np.pi * np.clip(beyond, 0.0, 1.0))), dtype=np.float64)


def _extend(series: Series, part: slice) -> FloatArray:
    """Return the samples of a slice that may reach beyond both ends, where the series is continued by prediction.

    An image of the samples would bend at the ends, and an inverse that grows with the frequency squared shows a bend as
    an impulse, which a band's largest value is made of.
    """
    size = series.size
    inner = series[slice(max(part.start, 0), min(part.stop, size))]
    before, after = max(-part.start, 0), max(part.stop - size, 0)
    head = continue_series(series[:TRAINED][::-1], before)[::-1] if before else inner[:0]
    tail = continue_series(series[max(size - TRAINED, 0) : size], after) if after else inner[:0]
    return np.concatenate([head, inner, tail])
