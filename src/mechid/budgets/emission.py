"""Torque on the base at a rate: the lines and bands of the model, what it lacks, and a bound of both.

The bound stays above a share of 95 % of what may be, line by line and band by band: parameters from their covariance,
what the model lacks at phases of its own, its size by as many rates of the bench as tell it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.budgets.flying_mechanism import Estimate
from mechid.budgets.line_of_sight import Response
from mechid.budgets.over_rate import torque_samples
from mechid.budgets.residual_source import EDGES_HZ, ResidualHere
from mechid.budgets.settings import LEVEL
from mechid.budgets.steady_state import SteadyState

RATIO, UPPER, DENSITY, WITHIN = "ratio", "upper bound", "density", "within noise"
"""How what the model lacks is carried from bench to flight: by the known ratio or the larger one; of an order that was
not tracked by the density there. Or it is not heard, and what noise may hide is in the bound alone."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Emission:
    """The torque on the base at one rate.

    Attributes
    ----------
    orders : (n,)
        Multiples of the step rate: the model's lines, then those that it lacks.
    frequency_hz : (n,)
    modelled : (n,) complex
        N m; 0 of those that it lacks.
    residual : (n,)
        Amplitude of what it lacks, N m, root mean square over what it may be.
    bound : (n,)
        The amplitude stays below with a probability of `LEVEL.bound`, N m.
    carried : tuple of str, (n,)
        `RATIO`, `UPPER`, `DENSITY` or `WITHIN`; empty where it lacks nothing.
    bands_hz : (b, 2)
        Third octaves, from and to.
    band_modelled, band_residual, band_bound : (b,)
        RMS in them, N m.
    """

    orders: FloatArray
    frequency_hz: FloatArray
    modelled: ComplexArray
    residual: FloatArray
    bound: FloatArray
    carried: tuple[str, ...]
    bands_hz: FloatArray
    band_modelled: FloatArray
    band_residual: FloatArray
    band_bound: FloatArray


def emission(response: Response, estimate: Estimate, highest_hz: float, seed: int) -> Emission:
    """Return the emission at the rate of a response, up to a frequency."""
    state, here = response.state, response.residual
    modelled = torque_samples(response, estimate, seed, response.lacking_limits())
    more, drawn, scale = _beside(response, highest_hz, np.random.default_rng(seed))
    orders = np.concatenate([state.step_orders, more])
    frequency = np.concatenate([state.frequency_hz, abs(state.rate) * more])
    lines = np.concatenate([state.lines, np.zeros(more.size)])
    samples = np.hstack([modelled, drawn])
    residual, limit = (
        here.at_orders(orders, LEVEL.line_spacing, sizes) if here is not None else np.zeros(orders.size)
        for sizes in ((here.amplitude, here.limit) if here is not None else (orders, orders))
    )
    bands = np.column_stack([EDGES_HZ[:-1], EDGES_HZ[1:]])[EDGES_HZ[:-1] < highest_hz]
    inside = (frequency[:, None] >= bands[:, 0]) & (frequency[:, None] < bands[:, 1])
    density = here.density[: len(bands)] * np.diff(bands).ravel() if here is not None else np.zeros(len(bands))
    tracked = np.isin(orders, here.orders) if here is not None else np.zeros(orders.size, dtype=np.bool_)
    power = 0.5 * np.abs(samples) ** 2 @ inside + scale * density
    return Emission(
        orders=orders,
        frequency_hz=frequency,
        modelled=lines,
        residual=residual,
        bound=np.quantile(np.abs(samples), LEVEL.bound, axis=0) + np.concatenate([state.error, np.zeros(more.size)]),
        carried=_carried(here, orders, residual, limit),
        bands_hz=bands,
        band_modelled=np.sqrt(0.5 * np.abs(lines) ** 2 @ inside),
        band_residual=np.sqrt(0.5 * np.where(tracked, residual, 0.0) ** 2 @ inside + density),
        band_bound=np.quantile(np.sqrt(power), LEVEL.bound, axis=0),
    )


def line_sigmas(estimate: Estimate, state: SteadyState) -> FloatArray:
    """Return the standard error of each torque line's amplitude, (n,) N m: covariance, what the model misses, error."""
    return _sigmas(estimate, state, 1.0)


def phase_sigmas(estimate: Estimate, state: SteadyState) -> FloatArray:
    """Return the standard error of each torque line's phase, (n,) rad, of the same as `line_sigmas`; pi at most."""
    across = _sigmas(estimate, state, 1j)
    return np.asarray(np.minimum(across / np.maximum(np.abs(state.lines), 1e-300), np.pi), dtype=np.float64)


def _sigmas(estimate: Estimate, state: SteadyState, turn: complex) -> FloatArray:
    """Return the standard error along each line's own phasor, or across it where that is turned by 1j, (n,) N m."""
    unit = turn * state.lines / np.maximum(np.abs(state.lines), 1e-300)
    slope = (np.conj(unit)[:, None] * state.gradient[:, : len(estimate.names)]).real
    own = np.einsum("ij,jk,ik->i", slope, estimate.covariance, slope)
    missed = estimate.discrepancy.of_lines(state.step_orders) * np.abs(state.lines)
    return np.asarray(np.sqrt(np.maximum(own, 0.0) + missed**2 + state.error**2), dtype=np.float64)


def _beside(
    response: Response, highest_hz: float, rng: np.random.Generator
) -> tuple[FloatArray, ComplexArray, FloatArray]:
    """Return orders at which the model has no line and the records have one, draws of these, and factors of a density.

    The factors, (k, 1), are what a power that so few rates tell may be, relative.
    """
    here = response.residual
    if here is None:
        return np.zeros(0), np.zeros((LEVEL.samples, 0), dtype=np.complex128), np.ones((LEVEL.samples, 1))
    lacking = (here.amplitude > 0.0) & (here.frequency_hz <= highest_hz)
    lacking &= ~np.isin(here.orders, response.state.step_orders)
    drawn = here.draws(here.amplitude[lacking], LEVEL.samples, rng)
    return here.orders[lacking], drawn, here.rates / rng.gamma(here.rates, size=(LEVEL.samples, 1))


def _carried(here: ResidualHere | None, orders: FloatArray, residual: FloatArray, limit: FloatArray) -> tuple[str, ...]:
    known = {} if here is None else dict(zip(here.orders.tolist(), here.known.tolist(), strict=True))
    words = (DENSITY if q not in known else RATIO if known[q] else UPPER for q in orders.tolist())
    return tuple(
        word if size > 0.0 else WITHIN if most > 0.0 else ""
        for word, size, most in zip(words, residual, limit, strict=True)
    )
