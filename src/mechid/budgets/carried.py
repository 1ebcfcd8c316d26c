"""By what a torque that the bench's model lacks is multiplied on its way from the bench's record to the flight's base.

Of what enters at the rotor, as a detent, friction, or a torque of the coils, the model itself knows: the plants of the
bench and of the flight, both linearised where the coils hold and nothing rubs, say what of a torque at the motor the
transducer saw and what the base will see. The coils' inputs drive both, and what is the same in both (the windings)
falls out of the ratio. Of what enters elsewhere, as at the output or beside the mechanism, it does not: there the
record counts as it is, and of both the larger is an upper bound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.budgets.settings import RESIDUALS
from mechid.plant.mechanism import Mechanism
from mechid.simulation.linearisation import held_inputs, holdings, linearise

GRID_HZ = np.geomspace(0.5, 5000.0, 1200)


@dataclass(frozen=True, eq=False)
class Carried:
    """The ratio of flight to bench over the frequency.

    Attributes
    ----------
    at_rotor : (n,) or None
        Of what enters at the rotor, at `GRID_HZ`; None where no input of the coils tells it.
    """

    at_rotor: FloatArray | None

    def ratio(self, frequency_hz: FloatArray) -> FloatArray:
        """Return by what an amplitude is multiplied, (n,): an upper bound where the path is not known."""
        return np.asarray(np.maximum(self._at_rotor(frequency_hz), 1.0))

    def known(self, frequency_hz: FloatArray) -> BoolArray:
        """Return where both paths agree, (n,), so that the ratio is no bound but known."""
        if self.at_rotor is None:
            return np.zeros(frequency_hz.shape, dtype=np.bool_)
        return np.asarray(np.abs(self._at_rotor(frequency_hz) - 1.0) <= RESIDUALS.agree, dtype=np.bool_)

    def _at_rotor(self, frequency_hz: FloatArray) -> FloatArray:
        if self.at_rotor is None:
            return np.ones(frequency_hz.shape)
        at = np.log(np.maximum(frequency_hz, GRID_HZ[0]))
        return np.asarray(np.interp(at, np.log(GRID_HZ), self.at_rotor))


def carried(bench: Mechanism, flying: Mechanism) -> Carried:
    """Return how what a torque record of the bench has left reaches the base in flight.

    Parameters
    ----------
    bench, flying : Mechanism
        As identified, its torque measured; as it flies, on a held base.
    """
    if bench.plant.inputs != flying.plant.inputs or not bench.plant.inputs:
        return Carried(None)
    seen, base = _from_motor(bench), _from_motor(flying)
    return Carried(_smooth(base) / _smooth(seen))


def _from_motor(mechanism: Mechanism) -> FloatArray:
    """Return the size of the torque's response to the inputs at `GRID_HZ`, where nothing rubs."""
    plant = mechanism.plant.with_outputs(("torque",))
    free = holdings(plant)[-1]
    about = linearise(plant, mechanism.kernel_values(), held_inputs(plant), 0.0, free)
    return np.asarray(np.linalg.norm(about.response(GRID_HZ)[:, 0, :], axis=1))


def _smooth(size: FloatArray) -> FloatArray:
    """Return the root mean square over the neighbourhood of each frequency of the grid."""
    each = round(np.log1p(RESIDUALS.width) / np.log(GRID_HZ[1] / GRID_HZ[0]))
    width = 2 * each + 1
    squares = np.convolve(np.pad(size**2, each, mode="edge"), np.full(width, 1.0 / width), mode="valid")
    return np.asarray(np.sqrt(squares))
