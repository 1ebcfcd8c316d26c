"""The torque on a held base at each rate of a way of stepping: lines, their errors, and what the model lacks beside.

The mechanism is the bench's, with the bench's load and voltage, without what only the test stand has unless that is
asked for: the machinery is that of the budget, whose flight may have other values.
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
from mechid.budgets.line_of_sight import Response
from mechid.budgets.operating_mode import OperatingMode, usual_highest_hz
from mechid.budgets.residual_source import residual_source
from mechid.budgets.steady_state import SteadyState
from mechid.exports.handover import Handover
from mechid.exports.stepping import Stepping
from mechid.identification.computation.parallel import one_core_algebra
from mechid.plant.flight import parts_left_on_bench, to_flight

SEED = 0
"""Of the draws behind a bound."""


@dataclass(frozen=True, eq=False)
class Forcing:
    """The torque on the base over the rate.

    Attributes
    ----------
    stepping : Stepping
    mode : OperatingMode
        The same with its rates, (r,) full steps/s.
    states : tuple of tuple of SteadyState, (r,)
        All motions found at each rate, the one from rest first.
    emissions : tuple of Emission, (r,)
        Of the motion that counts.
    """

    stepping: Stepping
    mode: OperatingMode
    states: tuple[tuple[SteadyState, ...], ...]
    emissions: tuple[Emission, ...]

    @property
    def largest(self) -> tuple[SteadyState, ...]:
        """Of the motions found at each rate the one with the largest torque, (r,): it counts."""
        return tuple(map(_largest, self.states))


def estimate_on_base(handover: Handover, values: Mapping[str, float] | None = None, *, stand: bool = False) -> Estimate:
    """Return what is known of the mechanism on a held base.

    Parameters
    ----------
    handover : Handover
    values : mapping of dotted name to float or None
        What differs in flight, in the mechanism file's units; None takes all of the bench.
    stand : bool
        Whether it keeps its test stand, so that its torque is what the transducer shows.

    Raises
    ------
    InputFileError
        No step command drives it, or a value cannot be; or the files in the fit's folder are damaged or of another fit.
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
    """Return the torque on the base at some rates, (r,) full steps/s, ascending.

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
    here = None if estimate.residual is None else estimate.residual.at(mode.command, state.rate)
    ones, lines = np.ones((state.lines.size, 1), dtype=np.complex128), state.lines[:, None]
    torque = Response(("torque",), state, ones, lines, 0.0, None, here)
    return emission(torque, estimate, mode.highest_hz, SEED)
