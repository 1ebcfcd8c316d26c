"""Torque on a held base at each rate of a stepping mode: lines, their errors, and emission missing in the model.

The mechanism has the load and voltage of the bench, by default without the test stand. The computation is shared with
the budget, in which values in flight may differ.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.attractors import steady_states
from mechid.budgets.discrepancy import Discrepancy, discrepancy_of
from mechid.budgets.emission import Emission, emission
from mechid.budgets.flying_mechanism import Estimate
from mechid.budgets.line_of_sight import torque_response
from mechid.budgets.operating_mode import OperatingMode, usual_highest_hz
from mechid.budgets.residual_source import residual_source
from mechid.budgets.steady_state import SteadyState
from mechid.exports.handover import Handover
from mechid.exports.stepping import Stepping
from mechid.identification.computation.parallel import one_core_algebra
from mechid.plant.flight import parts_left_on_bench, to_flight

SEED = 0
"""Seed of the draws from which bounds are computed."""


@dataclass(frozen=True, eq=False)
class Forcing:
    """Torque on the base over the rate.

    Attributes
    ----------
    stepping : Stepping
    mode : OperatingMode
        The same with its rates, (r,) in full steps/s.
    states : tuple of tuple of SteadyState, (r,)
        All motions found at each rate; the one from rest first.
    emissions : tuple of Emission, (r,)
        Emission of the motion with the largest torque.
    """

    stepping: Stepping
    mode: OperatingMode
    states: tuple[tuple[SteadyState, ...], ...]
    emissions: tuple[Emission, ...]

    @property
    def largest(self) -> tuple[SteadyState, ...]:
        """Motion with the largest torque at each rate, (r,)."""
        return tuple(map(_largest, self.states))


def estimate_on_base(handover: Handover, values: Mapping[str, float] | None = None, *, stand: bool = False) -> Estimate:
    """Return the estimate of the mechanism on a held base.

    Parameters
    ----------
    handover : Handover
    values : mapping of dotted name to float or None
        Values that differ in flight, in the units of the mechanism file; None takes all values of the bench.
    stand : bool
        Whether to keep the test stand, so that the torque is that at the transducer.

    Raises
    ------
    InputFileError
        No step command drives the mechanism, a value is impossible, or the files in the folder of the fit are damaged
        or belong to another fit.
    """
    bench, residuals = handover.mechanism, handover.residuals if handover.trials else None
    held = to_flight(bench, values, stand=stand)
    estimated = held.parameters.keys() - (values or {}).keys()
    kept = [k for k, name in enumerate(handover.names) if name in estimated]
    source = residual_source(residuals, bench, held) if residuals else None
    return Estimate(
        mechanism=held,
        names=tuple(handover.names[k] for k in kept),
        covariance=handover.covariance[np.ix_(kept, kept)],
        discrepancy=discrepancy_of(residuals, of_profiles_alone=source is not None) if residuals else Discrepancy(),
        left=parts_left_on_bench(bench, handover.names, stand=stand),
        residual=source,
    )


def forcing(estimate: Estimate, stepping: Stepping, rates: FloatArray) -> Forcing:
    """Compute the torque on the base at ascending rates, (r,) full steps/s.

    Raises
    ------
    FitError
        The mechanism diverged.
    """
    highest_hz = usual_highest_hz(stepping.command, float(rates[-1]))
    mode = OperatingMode(name=stepping.name, command=stepping.command, rates=rates, highest_hz=highest_hz)
    with one_core_algebra():
        states = steady_states(estimate.mechanism, mode, estimate.names, 1)
        exerted = tuple(_emission(estimate, mode, _largest(here)) for here in states)
    return Forcing(stepping, mode, states, exerted)


def _largest(states: tuple[SteadyState, ...]) -> SteadyState:
    return max(states, key=lambda state: state.rms)


def _emission(estimate: Estimate, mode: OperatingMode, state: SteadyState) -> Emission:
    # Without stored residuals, only the model and its parameter errors are known.
    here = None if estimate.residual is None else estimate.residual.at(mode.command, state.rate)
    return emission(torque_response(state, here), estimate, mode.highest_hz, SEED)
