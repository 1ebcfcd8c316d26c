"""Residual of the bench's records as a disturbance source: lines and spectral density.

At a flight rate, the amplitude of a line is the root mean square over nearby bench rates with the noise subtracted, and
zero where noise alone explains it. Its phase is unknown. It is modelled as a complex Gaussian of that size, with the
heavier tails due to estimating the size from few rates: for n rates, |E|^2 / A^2 is F(2, 2 n) distributed.

A model that lacks torque in some lines lacks it in others as well, below the noise. If anything is detected at a rate,
each undetected line may still be as large as the scatter of the noise power, its limit. The limit enters the bound but
not the nominal torque. For a complete model nothing is detected, and there is no limit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2, gamma

from mechid.analysis.fit_residuals import FitResiduals
from mechid.analysis.residual_emission import CENTRES_HZ, TRACKED, ResidualAtRate
from mechid.analysis.residual_file import ResidualRecord
from mechid.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from mechid.budgets.bench_to_flight import BenchToFlight, bench_to_flight
from mechid.budgets.settings import MOTION, RESIDUALS
from mechid.command import Command
from mechid.plant.mechanism import Mechanism
from mechid.signal.density import THIRD
from mechid.signal.noise import FLOOR_ERROR

EDGES_HZ = np.append(CENTRES_HZ / THIRD**0.5, CENTRES_HZ[-1] * THIRD**0.5)


@dataclass(frozen=True, kw_only=True, eq=False)
class ResidualHere:
    """Unmodelled torque on the base at one flight rate.

    Attributes
    ----------
    orders : (K,)
        Multiples of the step rate at which the bench's records were tracked.
    amplitude : (K,)
        Amplitude of the lines, N m, root mean square of their distribution; 0 where noise explains them.
    limit : (K,)
        The amplitude, or the limit of lines that noise explains.
    density : (B,)
        Density between the lines, (N m)^2/Hz, in the bands of `EDGES_HZ`.
    rates : int
        Number of bench rates used.
    known : (K,)
        Whether the path from bench to base is known; elsewhere the amplitude is an upper bound.
    outside : bool
        Whether the rate lies outside the measured range.
    """

    rate: float
    orders: FloatArray
    amplitude: FloatArray
    limit: FloatArray
    density: FloatArray
    rates: int
    known: BoolArray
    outside: bool

    @property
    def any(self) -> bool:
        """Whether any torque is unmodelled."""
        return bool(self.amplitude.any() or self.density.any())

    @property
    def frequency_hz(self) -> FloatArray:
        """Frequency of each line, (K,)."""
        return self.rate * self.orders

    def at_orders(self, orders: FloatArray, spacing: float, sizes: FloatArray) -> FloatArray:
        """Return `amplitude` or `limit` at any orders, (n,) N m; untracked orders use the density over the spacing."""
        own = dict(zip(self.orders.tolist(), sizes.tolist(), strict=True))
        return np.array(
            [own[q] if q in own else float(self._untracked_size(q, spacing)) for q in orders.tolist()], dtype=np.float64
        )

    def _untracked_size(self, order: float, spacing: float) -> float:
        band = int(np.searchsorted(EDGES_HZ, order * self.rate, side="right")) - 1
        if not 0 <= band < self.density.size:
            return 0.0
        return float(np.sqrt(2.0 * self.density[band] * spacing * self.rate))

    def draws(self, amplitude: FloatArray, count: int, rng: np.random.Generator) -> ComplexArray:
        """Return draws of lines of given sizes, (n,), as (count, n) N m."""
        if not amplitude.any():
            return np.zeros((count, amplitude.size), dtype=np.complex128)
        both = rng.normal(size=(2, count, amplitude.size))
        scale = np.sqrt(self.rates / rng.gamma(self.rates, size=(count, 1)))
        return np.asarray((both[0] + 1j * both[1]) * scale * amplitude / np.sqrt(2.0), dtype=np.complex128)


@dataclass(frozen=True, eq=False)
class ResidualSource:
    """Residuals of the bench's torque records, and their transfer to the base in flight."""

    records: tuple[ResidualRecord, ...]
    bench_to_flight: BenchToFlight

    def measured_range(self, command: Command) -> tuple[float, float] | None:
        """Return the least and the largest rate measured of a stepping, None where there is none."""
        rates = [at.rate for record in self._records_for(command)[0] for at in record.rates]
        return (min(rates), max(rates)) if rates else None

    def has_same_stepping(self, command: Command) -> bool:
        """Return whether any record has the command's stepping; otherwise all records are used."""
        return self._records_for(command)[1]

    def at(self, command: Command, rate: float) -> ResidualHere:
        """Return the unmodelled torque at a flight rate."""
        rate, seen = abs(rate), [(r, at) for r in self._records_for(command)[0] for at in r.rates]
        near = _nearest([at for _, at in seen], rate)
        cells = [seen[k] for k in near]
        # Bonferroni: the chance of a false alarm holds for all lines and bands of a rate together.
        orders = np.round(cells[0][1].orders, MOTION.digits) if cells else np.array(TRACKED)
        tests = orders.size + CENTRES_HZ.size
        amplitude, hidden = _lines([at for _, at in cells], RESIDUALS.false_alarm / tests)
        density = _density(cells, RESIDUALS.false_alarm / tests)
        limit = np.where(amplitude > 0.0, amplitude, hidden if amplitude.any() or density.any() else 0.0)
        rates = [at.rate for _, at in seen]
        outside = not rates or not min(rates) / (1.0 + RESIDUALS.near) <= rate <= max(rates) * (1.0 + RESIDUALS.near)
        # Beyond the measured rates, inertial disturbances grow with the rate squared.
        grown = max(rate / max(rates), 1.0) ** 2 if rates else 1.0
        frequency = rate * orders
        factor = self.bench_to_flight.ratio(frequency) * grown
        return ResidualHere(
            rate=rate,
            orders=orders,
            amplitude=amplitude * factor,
            limit=limit * factor,
            density=density * (self.bench_to_flight.ratio(CENTRES_HZ) * grown) ** 2,
            rates=max(len(cells), 1),
            known=self.bench_to_flight.paths_agree(frequency),
            outside=outside,
        )

    def _records_for(self, command: Command) -> tuple[tuple[ResidualRecord, ...], bool]:
        alike = tuple(
            r for r in self.records if (r.stepping, r.microsteps) == (command.stepping, command.microsteps) and r.rates
        )
        return (alike, True) if alike else (self.records, False)


def residual_source(residuals: FitResiduals, bench: Mechanism, flying: Mechanism) -> ResidualSource | None:
    """Return the residuals of a fit's torque records as a source of the flying mechanism; None without any."""
    left = residuals.torques
    return ResidualSource(left, bench_to_flight(bench, flying)) if left else None


def _nearest(cells: Sequence[ResidualAtRate], rate: float) -> list[int]:
    """Return the positions of the nearby bench rates, at least `RESIDUALS.fewest` if there are as many."""
    off = np.array([abs(np.log(at.rate / rate)) for at in cells])
    ranked = np.argsort(off, kind="stable")
    near = int(np.sum(off <= np.log1p(RESIDUALS.near)))
    return [int(k) for k in ranked[: max(near, RESIDUALS.fewest)]]


def _lines(cells: Sequence[ResidualAtRate], alarm: float) -> tuple[FloatArray, FloatArray]:
    """Return the amplitude at each tracked order, N m, and the torque that noise may hide there.

    The amplitude is 0 if noise exceeds it with more than the given probability.
    """
    if not cells:
        return np.zeros(len(TRACKED)), np.zeros(len(TRACKED))
    power, noise = (np.array([getattr(at, name) for at in cells]) ** 2 for name in ("amplitude", "sigma"))
    windows = np.array([at.windows for at in cells])[:, None]
    known = np.isfinite(power) & np.isfinite(noise) & (noise > 0.0)
    power, noise, count = (
        np.where(known, values, 0.0) for values in (power, noise, np.broadcast_to(windows, power.shape))
    )
    ratio = np.divide(power, noise, out=np.zeros_like(power), where=noise > 0.0)
    total, shape = (count * ratio).sum(axis=0), count.sum(axis=0)
    heard = (shape > 0) & (total > gamma.ppf(1.0 - alarm, np.maximum(shape, 1)))
    mean, alone = ((values.sum(axis=0) / np.maximum(known.sum(axis=0), 1)) for values in (power - noise, noise))
    hidden = np.sqrt(alone / np.sqrt(np.maximum(shape, 1)))
    return np.where(heard, np.sqrt(np.maximum(mean, 0.0)), 0.0), hidden


def _lines_in_bands(rate: float) -> IntArray:
    """Return the number of tracked lines in each band, (B,)."""
    return np.histogram(rate * np.array(TRACKED), EDGES_HZ)[0]


def _density(cells: Sequence[tuple[ResidualRecord, ResidualAtRate]], alarm: float) -> FloatArray:
    """Return the density in each band less that of white noise, 0 where noise explains it, (N m)^2/Hz."""
    if not cells:
        return np.zeros(CENTRES_HZ.size)
    density = np.array([at.density for _, at in cells])
    floor = np.array([record.noise_density for record, _ in cells])[:, None]
    # Bins of tracked lines are excluded from the density, so that no line is counted twice.
    bins = np.array([at.duration_s * np.diff(EDGES_HZ) - at.windows * _lines_in_bands(at.rate) for _, at in cells])
    known = np.isfinite(density)
    weight = np.where(known, np.maximum(2.0 * bins, 2.0), 0.0)
    total = weight.sum(axis=0)
    mean, noise = (
        (weight * np.where(known, values, 0.0)).sum(axis=0) / np.maximum(total, 1e-300)
        for values in (density, np.broadcast_to(floor, density.shape))
    )
    # Neighbouring bins of a Hann window are correlated: 1.5 of them have the variance of one independent bin.
    hann = 1.5
    degrees = np.maximum(total / hann, 1.0)
    samples = sum(record.sample_rate_hz * at.duration_s for record, at in cells)
    unsure = 1.0 + 2.0 * RESIDUALS.sigmas * FLOOR_ERROR / np.sqrt(samples)
    least = noise * unsure * chi2.ppf(1.0 - alarm, degrees) / degrees
    return np.where((total > 0.0) & (mean > least), mean - noise, 0.0)
