"""Ratio of the base torque in flight to the measured torque on the bench, for torque that the model does not explain.

For torque that enters at the rotor (a detent, friction, the coils), the model provides the ratio: the plants of bench
and flight, both linearised with the coils fed and all friction sliding, give the response at the transducer and
at the base to a torque at the motor. Both plants are driven through the inputs of the coils, so that their common part
(the windings) cancels. For torque that enters elsewhere, at the output or outside the mechanism, the ratio is unknown
and the record is used as it is. The larger of the two is an upper bound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.budgets.settings import RESIDUALS
from mechid.plant.mechanism import Mechanism
from mechid.plant.pulses import FED_MODE
from mechid.simulation.linearisation import held_inputs, holdings, linearise

GRID_HZ = np.geomspace(0.5, 5000.0, 1200)


@dataclass(frozen=True, eq=False)
class BenchToFlight:
    """Ratio of flight to bench over the frequency.

    Attributes
    ----------
    at_rotor : (n,) or None
        Ratio for torque that enters at the rotor, at `GRID_HZ`; None if no input of the coils determines it.
    """

    at_rotor: FloatArray | None

    def ratio(self, frequency_hz: FloatArray) -> FloatArray:
        """Return the factor of an amplitude, (n,); an upper bound where the path is unknown."""
        return np.asarray(np.maximum(self._ratio_at_rotor(frequency_hz), 1.0))

    def paths_agree(self, frequency_hz: FloatArray) -> BoolArray:
        """Return where both paths agree, (n,), so that the ratio is exact and not only a bound."""
        if self.at_rotor is None:
            return np.zeros(frequency_hz.shape, dtype=np.bool_)
        return np.asarray(np.abs(self._ratio_at_rotor(frequency_hz) - 1.0) <= RESIDUALS.agree, dtype=np.bool_)

    def _ratio_at_rotor(self, frequency_hz: FloatArray) -> FloatArray:
        if self.at_rotor is None:
            return np.ones(frequency_hz.shape)
        # The grid is geometric: interpolation is linear in the logarithm.
        at = np.log(np.maximum(frequency_hz, GRID_HZ[0]))
        return np.asarray(np.interp(at, np.log(GRID_HZ), self.at_rotor))


def bench_to_flight(bench: Mechanism, flying: Mechanism) -> BenchToFlight:
    """Return the transfer of the residual of a bench torque record to the base in flight.

    Parameters
    ----------
    bench : Mechanism
        As identified, with its torque measured.
    flying : Mechanism
        In flight, on a held base.
    """
    if bench.plant.inputs != flying.plant.inputs or not bench.plant.inputs:
        return BenchToFlight(None)
    seen, base = _torque_response(bench), _torque_response(flying)
    if not (np.any(seen) and np.any(base)):
        return BenchToFlight(None)
    return BenchToFlight(_smooth(base) / _smooth(seen))


def _torque_response(mechanism: Mechanism) -> FloatArray:
    """Return the magnitude of the torque's response to the inputs at `GRID_HZ`, with all friction sliding."""
    plant = mechanism.plant.with_outputs(("torque",))
    # The last way to hold is the one in which nothing sticks. Open coils would pass no input on, so they are fed.
    free = dict(holdings(plant)[-1])
    for switch in plant.switches:
        free |= switch.modes.get(FED_MODE, {})
    about = linearise(plant, mechanism.kernel_values(), held_inputs(plant), 0.0, free)
    return np.asarray(np.linalg.norm(about.response(GRID_HZ)[:, 0, :], axis=1))


def _smooth(size: FloatArray) -> FloatArray:
    """Return the root mean square over the neighbourhood of each frequency of the grid."""
    # Resonance and antiresonance shift between bench and flight; a smoothed ratio has no spikes between them.
    each = round(np.log1p(RESIDUALS.width) / np.log(GRID_HZ[1] / GRID_HZ[0]))
    width = 2 * each + 1
    squares = np.convolve(np.pad(size**2, each, mode="edge"), np.full(width, 1.0 / width), mode="valid")
    return np.asarray(np.sqrt(squares))
