"""Torque on the base at one rate: modelled lines and bands, unmodelled torque, and a bound of both.

The bound is a 95 % quantile of each line and each band. It includes the covariance of the parameters, unmodelled torque
at random phases, and the uncertainty of its size, which follows from the number of bench rates that determine it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.budgets.flying_mechanism import Estimate
from mechid.budgets.line_of_sight import Response
from mechid.budgets.residual_source import EDGES_HZ, ResidualHere
from mechid.budgets.settings import LEVEL
from mechid.budgets.steady_state import SteadyState
from mechid.budgets.torque_draws import draw_torque

RATIO, UPPER, DENSITY, WITHIN = "ratio", "upper bound", "density", "within noise"
"""How unmodelled torque is transferred from bench to flight: by the known ratio, by the larger ratio, or, for an order
that was not tracked, by the density at its frequency. `WITHIN` is not above the noise: only the bound contains it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Emission:
    """Torque on the base at one rate.

    Attributes
    ----------
    orders : (n,)
        Multiples of the step rate: the modelled lines, followed by the unmodelled ones.
    frequency_hz : (n,)
    modelled : (n,) complex
        N m; 0 for unmodelled lines.
    residual : (n,)
        Amplitude of the unmodelled torque, N m, root mean square of its distribution.
    bound : (n,)
        Amplitude that is not exceeded with a probability of `LEVEL.bound`, N m.
    transfer_rules : tuple of str, (n,)
        `RATIO`, `UPPER`, `DENSITY` or `WITHIN`; empty where no torque is unmodelled.
    bands_hz : (b, 2)
        Third octaves, lower and upper edge.
    band_modelled, band_residual, band_bound : (b,)
        RMS in each band, N m.
    """

    orders: FloatArray
    frequency_hz: FloatArray
    modelled: ComplexArray
    residual: FloatArray
    bound: FloatArray
    transfer_rules: tuple[str, ...]
    bands_hz: FloatArray
    band_modelled: FloatArray
    band_residual: FloatArray
    band_bound: FloatArray


def emission(response: Response, estimate: Estimate, highest_hz: float, seed: int) -> Emission:
    """Return the emission at the rate of a response, up to a frequency."""
    drawn, here = draw_torque(response, estimate, highest_hz, seed), response.residual
    bands = np.column_stack([EDGES_HZ[:-1], EDGES_HZ[1:]])[EDGES_HZ[:-1] < highest_hz]
    inside = (drawn.frequency_hz[:, None] >= bands[:, 0]) & (drawn.frequency_hz[:, None] < bands[:, 1])
    density = drawn.density[: len(bands)] * np.diff(bands).ravel()
    # An untracked order is part of the density already; counting it as a line too would double it.
    tracked = np.isin(drawn.orders, here.orders) if here is not None else np.zeros(drawn.orders.size, dtype=np.bool_)
    # Lines within a band add in power: their phases are independent over the band.
    power = 0.5 * np.abs(drawn.samples) ** 2 @ inside + drawn.scale * density
    return Emission(
        orders=drawn.orders,
        frequency_hz=drawn.frequency_hz,
        modelled=drawn.modelled,
        residual=drawn.residual,
        bound=np.quantile(np.abs(drawn.samples), LEVEL.bound, axis=0) + drawn.error,
        transfer_rules=_transfer_rules(here, drawn.orders, drawn.residual, drawn.limit),
        bands_hz=bands,
        band_modelled=np.sqrt(0.5 * np.abs(drawn.modelled) ** 2 @ inside),
        band_residual=np.sqrt(0.5 * np.where(tracked, drawn.residual, 0.0) ** 2 @ inside + density),
        band_bound=np.quantile(np.sqrt(power), LEVEL.bound, axis=0),
    )


def line_sigmas(estimate: Estimate, state: SteadyState) -> FloatArray:
    """Return the standard error of each torque line's amplitude, (n,) N m.

    It combines the covariance of the parameters, the model discrepancy and the numerical error.
    """
    return _sigmas(estimate, state, 1.0)


def phase_sigmas(estimate: Estimate, state: SteadyState) -> FloatArray:
    """Return the standard error of each torque line's phase, (n,) rad, at most pi; sources as in `line_sigmas`."""
    across = _sigmas(estimate, state, 1j)
    return np.asarray(np.minimum(across / np.maximum(np.abs(state.lines), 1e-300), np.pi), dtype=np.float64)


def _sigmas(estimate: Estimate, state: SteadyState, turn: complex) -> FloatArray:
    """Return the standard error along each line's own phasor, or across it for a turn of 1j, (n,) N m."""
    unit = turn * state.lines / np.maximum(np.abs(state.lines), 1e-300)
    slope = (np.conj(unit)[:, None] * state.gradient[:, : len(estimate.names)]).real
    own = np.einsum("ij,jk,ik->i", slope, estimate.covariance, slope)
    missed = estimate.discrepancy.of_lines(state.step_orders) * np.abs(state.lines)
    return np.asarray(np.sqrt(np.maximum(own, 0.0) + missed**2 + state.error**2), dtype=np.float64)


def _transfer_rules(
    here: ResidualHere | None, orders: FloatArray, residual: FloatArray, limit: FloatArray
) -> tuple[str, ...]:
    known = {} if here is None else dict(zip(here.orders.tolist(), here.known.tolist(), strict=True))
    words = (DENSITY if q not in known else RATIO if known[q] else UPPER for q in orders.tolist())
    return tuple(
        word if size > 0.0 else WITHIN if most > 0.0 else ""
        for word, size, most in zip(words, residual, limit, strict=True)
    )
