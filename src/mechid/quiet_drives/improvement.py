"""Emission before and after: lines with their bounds, gain over the covariance, sensitivity, and other units.

The gain at a rate is the level with the nominal table over that with the found one, in dB. Its bound
is the 5 % quantile over draws of `budgets.torque_draws`, which hold covariance, model discrepancy and unmodelled
torque; both tables share the draws.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.budgets.emission import emission
from mechid.budgets.flying_mechanism import Estimate
from mechid.budgets.line_of_sight import Response, torque_response
from mechid.budgets.operating_mode import OperatingMode, usual_highest_hz
from mechid.budgets.settings import LEVEL
from mechid.budgets.steady_state import enough_substeps, steady_state
from mechid.budgets.torque_draws import draw_torque
from mechid.errors import InputFileError
from mechid.plant.mechanism import Mechanism
from mechid.quiet_drives.periodic_torque import PeriodicTorque
from mechid.quiet_drives.quantity import TORQUE, Quantity
from mechid.quiet_drives.settings import QUIET
from mechid.quiet_drives.table_command import table_command


@dataclass(frozen=True)
class LineAt:
    """One line of the torque: amplitude and 95 % bound in N m, at a rate in full steps/s."""

    rate: float
    order: float
    amplitude: float
    bound: float


@dataclass(frozen=True)
class Gain:
    """Reduction of the level at a rate.

    Attributes
    ----------
    rate : float
        Full steps/s.
    before, after : float
        RMS of the lines, N m or rad.
    gain_db : float
    bound_db : float
        Gain that is exceeded with a probability of 95 %.
    """

    rate: float
    before: float
    after: float
    gain_db: float
    bound_db: float


@dataclass(frozen=True, eq=False)
class Improvement:
    """Emission with the nominal table and with the found one.

    Attributes
    ----------
    before, after : tuple of LineAt
    gains : tuple of Gain
    sensitivity : mapping of str to float
        By parameter, the change of the mean gain over the design rates, dB, for a parameter
        `QUIET.sensitivity_sigmas` standard errors higher or lower, whichever is worse.
    units : mapping of str to tuple of Gain
        Gains of other units with this table; their bounds are the gains.
    uncovered_share : float
        Largest share of the RMS torque with the nominal table at frequencies that the structure does not cover.
    """

    before: tuple[LineAt, ...]
    after: tuple[LineAt, ...]
    gains: tuple[Gain, ...]
    sensitivity: Mapping[str, float]
    units: Mapping[str, tuple[Gain, ...]]
    uncovered_share: float = 0.0


def improvement(
    estimate: Estimate,
    base: FloatArray,
    table: FloatArray,
    rates: Sequence[float],
    units: Mapping[str, Mechanism],
    seed: int,
    quantity: Quantity = TORQUE,
) -> Improvement:
    """Return the emission with two tables, (4 n, 2), at rates in full steps/s; lines are of the torque."""
    before: list[LineAt] = []
    after: list[LineAt] = []
    gains, uncovered = [], 0.0
    for rate in rates:
        ones = [_response(estimate, own, rate) for own in (base, table)]
        highest_hz = _mode(base, rate).highest_hz
        for lines, response in zip((before, after), ones, strict=True):
            found = emission(response, estimate, highest_hz, seed)
            lines += [
                LineAt(rate, float(order), float(abs(size)), float(bound))
                for order, size, bound in zip(found.orders, found.modelled, found.bound, strict=True)
            ]
        drawn = [draw_torque(response, estimate, highest_hz, seed) for response in ones]
        levels = [_rms(one.samples, quantity.weight(one.frequency_hz)) for one in drawn]
        own = [float(_rms(one.state.lines, quantity.weight(one.state.frequency_hz))) for one in ones]
        uncovered = max(uncovered, quantity.uncovered_share(ones[0].state.frequency_hz, ones[0].state.lines))
        low = float(np.quantile(_gain_db(levels[0], levels[1]), 1.0 - LEVEL.bound))
        gains.append(Gain(rate, own[0], own[1], float(_gain_db(own[0], own[1])), low))
    return Improvement(
        before=tuple(before),
        after=tuple(after),
        gains=tuple(gains),
        sensitivity=_sensitivity(estimate, base, table, rates, quantity),
        units={name: unit_gains(unit, base, table, rates, quantity) for name, unit in units.items()},
        uncovered_share=uncovered,
    )


def unit_gains(
    mechanism: Mechanism, base: FloatArray, table: FloatArray, rates: Sequence[float], quantity: Quantity = TORQUE
) -> tuple[Gain, ...]:
    """Return the gains of a mechanism at its own values, where it follows both tables."""
    out = []
    for rate in rates:
        torque = PeriodicTorque(mechanism, rate, quantity)
        before, after = torque.lines(base), torque.lines(table)
        if before is not None and after is not None:
            gain = float(_gain_db(before.level, after.level))
            out.append(Gain(rate, before.level, after.level, gain, gain))
    return tuple(out)


def moved_mechanisms(estimate: Estimate, moves: FloatArray) -> list[Mechanism]:
    """Return mechanisms at deviations of the estimated parameters, (k, n), in the file's units.

    Deviations that leave a parameter's physical limits or contradict others are halved until they do not.
    """
    return [_move_mechanism(estimate, move) for move in moves]


def _move_mechanism(estimate: Estimate, move: FloatArray) -> Mechanism:
    own = estimate.mechanism
    for _ in range(8):
        values = {name: own.value(name) + float(by) for name, by in zip(estimate.names, move, strict=True)}
        moved = own.with_values(values)
        if not any(True for _ in moved.contradictions()) and _is_physical(moved, estimate.names):
            return moved
        move = 0.5 * move
    return own


def _is_physical(mechanism: Mechanism, names: Sequence[str]) -> bool:
    own = [mechanism.parameters[name] for name in names]
    return all(q.declaration.lower <= q.value <= q.declaration.upper for q in own)


def _sensitivity(
    estimate: Estimate, base: FloatArray, table: FloatArray, rates: Sequence[float], quantity: Quantity
) -> dict[str, float]:
    if not estimate.names:
        return {}
    sigma = np.sqrt(np.diag(estimate.covariance)) * QUIET.sensitivity_sigmas
    own = _mean_gain(estimate.mechanism, base, table, rates, quantity)
    out = {}
    for k, name in enumerate(estimate.names):
        move = np.where(np.arange(sigma.size) == k, sigma, 0.0)
        sides = moved_mechanisms(estimate, np.array([move, -move]))
        out[name] = min(_mean_gain(side, base, table, rates, quantity) for side in sides) - own
    return out


def _mean_gain(
    mechanism: Mechanism, base: FloatArray, table: FloatArray, rates: Sequence[float], quantity: Quantity
) -> float:
    gains = [one.gain_db for one in unit_gains(mechanism, base, table, rates, quantity)]
    if not gains:
        raise InputFileError("the rotor loses steps at every design rate with parameters two standard errors off")
    return float(np.mean(gains))


def _response(estimate: Estimate, table: FloatArray, rate: float) -> Response:
    mode = _mode(table, rate)
    substeps = enough_substeps(estimate.mechanism, mode, estimate.names)
    state = steady_state(estimate.mechanism, mode, rate, estimate.names, substeps)
    residual = None if estimate.residual is None else estimate.residual.at(mode.command, rate)
    return torque_response(state, residual)


def _mode(table: FloatArray, rate: float) -> OperatingMode:
    command = table_command(table, rate)
    return OperatingMode(
        name="table", command=command, rates=np.array([rate]), highest_hz=usual_highest_hz(command, rate)
    )


def _rms(lines: ComplexArray, weight: FloatArray) -> FloatArray:
    """Return the RMS over weighted lines, the last axis."""
    return np.asarray(np.sqrt(0.5 * np.sum(np.abs(weight * lines) ** 2, axis=-1)))


def _gain_db(before: FloatArray | float, after: FloatArray | float) -> FloatArray:
    return np.asarray(20.0 * np.log10(np.maximum(before, 1e-300) / np.maximum(after, 1e-300)))
