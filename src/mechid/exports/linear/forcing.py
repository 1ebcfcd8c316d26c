"""Harmonic forcing of a linear model: torque on the base at steady rates by orders of the step rate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mechid.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from mechid.budgets.emission import line_sigmas, phase_sigmas
from mechid.budgets.flying_mechanism import Estimate
from mechid.budgets.steady_state import SteadyState
from mechid.exports.forcing import Forcing

KEPT = 0.01
"""Share of the largest line at any rate; orders below it at all rates are omitted."""
SAME_ORDER = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class OrderForcing:
    """Lines of the torque on a held base over the rate, for one stepping mode.

    At a rate r the torque is the sum over the orders q of Re(line exp(2 pi i q r t)), N m, with t = 0 at a step.
    Values are NaN if the frequency of an order is above the analysed range, or if the motion has no such line.

    Attributes
    ----------
    name : str
        Name of the stepping mode, e.g. ``"micro16"``.
    stepping, waveform : str
    microsteps : int
    rates : (r,)
        Rates in full steps/s.
    orders : (q,)
        Multiples of the step rate.
    lines : (r, q) complex
        Complex peak amplitudes in N m.
    sigma : (r, q)
        Standard error of the amplitude in N m.
    phase_sigma : (r, q)
        Standard error of the phase in rad.
    bound : (r, q)
        95 % upper bound of the amplitude in N m, including emission missing in the model.
    by_uncertain : (r, q, k) complex
        Derivatives of the lines with respect to the uncertain parameters.
    rms : (r,)
        RMS of the whole torque about its mean in N m.
    repeats : (r,) bool
        Whether the motion is periodic; otherwise its lines are averages over a stretch.
    """

    name: str
    stepping: str
    waveform: str
    microsteps: int
    rates: FloatArray
    orders: FloatArray
    lines: ComplexArray
    sigma: FloatArray
    phase_sigma: FloatArray
    bound: FloatArray
    by_uncertain: ComplexArray
    rms: FloatArray
    repeats: BoolArray

    def to_dict(self) -> dict[str, Any]:
        """Return lists and plain numbers; lines as amplitude and phase, derivatives as real and imaginary part."""
        return {
            "name": self.name,
            "stepping": self.stepping,
            "microsteps": self.microsteps,
            "waveform": self.waveform,
            "rates": self.rates.tolist(),
            "orders": self.orders.tolist(),
            "amplitude": np.abs(self.lines).tolist(),
            "phase": np.angle(self.lines).tolist(),
            "sigma": self.sigma.tolist(),
            "phase_sigma": self.phase_sigma.tolist(),
            "bound": self.bound.tolist(),
            "by_uncertain": {"real": self.by_uncertain.real.tolist(), "imag": self.by_uncertain.imag.tolist()},
            "rms": self.rms.tolist(),
            "repeats": self.repeats.tolist(),
        }


def sort_by_orders(forcing: Forcing, estimate: Estimate) -> OrderForcing:
    """Sort a forcing by orders, using the motion with the largest torque at each rate."""
    states, command = forcing.largest, forcing.stepping.command
    orders = _orders(states)
    shape = (len(states), orders.size)
    lines, slopes = np.full(shape, np.nan + 0j), np.full((*shape, len(estimate.names)), np.nan + 0j)
    sigma, phase_sigma, bound = (np.full(shape, np.nan) for _ in range(3))
    for row, (state, exerted) in enumerate(zip(states, forcing.emissions, strict=True)):
        own, at = _find_lines(state, orders)
        lines[row, at], slopes[row, at] = state.lines[own], state.gradient[own]
        sigma[row, at], phase_sigma[row, at] = line_sigmas(estimate, state)[own], phase_sigmas(estimate, state)[own]
        # The bounds of modelled lines come first, so the indices of the lines apply.
        bound[row, at] = exerted.bound[own]
    return OrderForcing(
        name=forcing.stepping.name,
        stepping=command.stepping,
        microsteps=command.steps_per_full_step,
        waveform=command.waveform_name,
        rates=forcing.mode.rates,
        orders=orders,
        lines=lines,
        sigma=sigma,
        phase_sigma=phase_sigma,
        bound=bound,
        by_uncertain=slopes,
        rms=np.array([s.rms for s in states]),
        repeats=np.array([s.periods > 0 for s in states]),
    )


def _orders(states: tuple[SteadyState, ...]) -> FloatArray:
    """Return the orders that are large at any rate, (q,) ascending."""
    largest = max((float(np.abs(s.lines).max(initial=0.0)) for s in states), default=0.0)
    every = [s.step_orders[np.abs(s.lines) > KEPT * largest] for s in states]
    # Rounded, since equal orders at different rates differ by rounding errors.
    return np.unique(np.round(np.concatenate([np.zeros(0), *every]), 9))


def _find_lines(state: SteadyState, orders: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the indices of lines at the given orders, and the indices of these orders."""
    near = np.abs(state.step_orders[:, None] - orders) < SAME_ORDER
    own, at = np.nonzero(near)
    return own, at
