"""Draws of the torque on the base at one rate: lines of model and residual, and the density between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import BoolArray, ComplexArray, FloatArray
from mechid.budgets.flying_mechanism import Estimate
from mechid.budgets.line_of_sight import Response
from mechid.budgets.over_rate import torque_samples
from mechid.budgets.residual_source import EDGES_HZ, ResidualHere
from mechid.budgets.settings import LEVEL


@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueDraws:
    """Lines of the torque at one rate with their draws.

    Attributes
    ----------
    orders : (n,)
        Multiples of the step rate: the modelled lines, followed by those that only the records have.
    frequency_hz : (n,)
    modelled : (n,) complex
        N m; 0 for lines that only the records have.
    residual : (n,)
        Amplitude of the unmodelled torque, N m; 0 where noise explains it.
    limit : (n,)
        The same, or what noise may hide.
    error : (n,)
        Numerical error of the modelled lines, N m.
    samples : (k, n) complex
        Draws from the parameters' covariance with the unmodelled torque at random phases, N m.
    scale : (k, 1)
        Draws of the relative size of the density, which few rates determine.
    density : (b,)
        Between the lines, (N m)^2/Hz, in the bands of `EDGES_HZ`.
    """

    orders: FloatArray
    frequency_hz: FloatArray
    modelled: ComplexArray
    residual: FloatArray
    limit: FloatArray
    error: FloatArray
    samples: ComplexArray
    scale: FloatArray
    density: FloatArray


def draw_torque(
    response: Response,
    estimate: Estimate,
    highest_hz: float,
    seed: int,
    count: int = LEVEL.samples,
    *,
    with_hidden: bool = False,
) -> TorqueDraws:
    """Return draws of the torque's lines at the rate of a response, up to a frequency.

    Parameters
    ----------
    response : Response
    estimate : Estimate
    highest_hz : float
    seed : int
    count : int
        Number of draws k.
    with_hidden : bool
        Whether orders without a modelled line that noise alone explains have a line too, as large as noise may hide.
    """
    state, here = response.state, response.residual
    samples = torque_samples(response, estimate, seed, response.residual_limits(), count)
    rng, none = np.random.default_rng(seed), np.zeros(0)
    more, drawn, scale = none, np.zeros((count, 0), dtype=np.complex128), np.ones((count, 1))
    if here is not None:
        size = here.limit if with_hidden else here.amplitude
        alone = _is_unmodelled(here, size, state.step_orders, highest_hz)
        # The mean of n powers scatters as a gamma variable of shape n; its inverse samples the power given the mean.
        more, drawn = here.orders[alone], here.draws(size[alone], count, rng)
        scale = here.rates / rng.gamma(here.rates, size=(count, 1))
    orders = np.concatenate([state.step_orders, more])
    residual, limit = (
        here.at_orders(orders, LEVEL.line_spacing, sizes) if here is not None else np.zeros(orders.size)
        for sizes in ((here.amplitude, here.limit) if here is not None else (orders, orders))
    )
    return TorqueDraws(
        orders=orders,
        frequency_hz=np.concatenate([state.frequency_hz, abs(state.rate) * more]),
        modelled=np.concatenate([state.lines, np.zeros(more.size)]),
        residual=residual,
        limit=limit,
        error=np.concatenate([state.error, np.zeros(more.size)]),
        samples=np.hstack([samples, drawn]),
        scale=scale,
        density=here.density if here is not None else np.zeros(EDGES_HZ.size - 1),
    )


def _is_unmodelled(here: ResidualHere, size: FloatArray, modelled: FloatArray, highest_hz: float) -> BoolArray:
    """Tell which tracked orders have a line up to a frequency that the model does not have, (K,)."""
    return (size > 0.0) & (here.frequency_hz <= highest_hz) & ~np.isin(here.orders, modelled)
