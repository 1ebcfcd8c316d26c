"""Coupling of the structure's motion back to the torque: the one-way criterion and the two-way model.

In the one-way model the torque on a held base passes through the transfer function. This suffices where the
driving-point receptance R times the mechanism's dynamic stiffness K is small: the torque on a moving base is T = T_held
+ K beta with beta = R T, which requires |R K| << 1. K follows from the plant's equations with a driven base.
"""

from __future__ import annotations

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.command import Command
from mechid.plant.flight import moving_base_objection, with_base
from mechid.plant.layout import Base, Flying
from mechid.plant.mechanism import Mechanism
from mechid.plant.moving_base import ACCELERATION
from mechid.simulation.linearisation import held_inputs, holdings, linearise
from mechid.structure import Modes, Structure


def dynamic_stiffness(mechanism: Mechanism, frequency_hz: FloatArray, command: Command | None = None) -> ComplexArray:
    """Return the torque on the base per base angle, (h, n) N m/rad, linearised at the held position.

    Each row is one way in which the switches may hold: friction sticks or slides, a gear is within its backlash or in
    contact (`simulation.linearisation.holdings`). Which of them applies during the motion is not known beforehand.

    Parameters
    ----------
    mechanism : Mechanism
        In flight, on a held base.
    frequency_hz : (n,)
        Above 0.
    command : Command or None
        The coils hold its start position; None is a full step at angle 0.

    Raises
    ------
    InputFileError
        A user-defined block does not specify how it moves with its base.
    FitError
        There is no equilibrium near the commanded angle.
    """
    driven = with_base(mechanism, Flying(base=Base.DRIVEN))
    plant, p = driven.plant, driven.kernel_values()
    inputs, at = held_inputs(plant, command), plant.inputs.index(ACCELERATION)
    angle = command.start_angle_rad if command else 0.0
    # The base is driven by its acceleration, which is -omega^2 times its angle.
    square = (2.0 * np.pi * frequency_hz) ** 2
    rows = [linearise(plant, p, inputs, angle, how).response(frequency_hz)[:, 0, at] for how in holdings(plant)]
    return np.asarray(-square * np.array(rows), dtype=np.complex128)


def loop_gain(
    structure: Structure, mechanism: Mechanism, frequency_hz: FloatArray, command: Command | None = None
) -> FloatArray:
    """Return |R K| at each frequency, (n,), the largest over the ways to hold; NaN where R or K is unknown."""
    receptance = structure.to_interface(frequency_hz)
    if moving_base_objection(mechanism):
        return np.full(frequency_hz.size, np.nan)
    gains = np.abs(receptance * dynamic_stiffness(mechanism, frequency_hz, command))
    return np.asarray(gains.max(axis=0), dtype=np.float64)


def largest_loop_gain(
    structure: Structure, mechanism: Mechanism, frequency_hz: FloatArray, command: Command | None = None
) -> float:
    """Return the largest |R K| at frequencies (n,) in Hz, NaN if R or K is unknown at all of them."""
    gains = loop_gain(structure, mechanism, frequency_hz, command)
    known = gains[np.isfinite(gains)]
    return float(known.max()) if known.size else float("nan")


def coupled_modes(structure: Structure, below_hz: float) -> Modes | None:
    """Return the modes to couple with the mechanism; None if the structure has none."""
    if not isinstance(structure.model, Modes):
        return None
    modes = structure.model
    # A mode that does not move the interface takes no part in the coupling.
    keep = (modes.frequency_hz <= below_hz) & (modes.interface != 0.0)
    if not keep.any():
        return None
    return Modes(modes.frequency_hz[keep], modes.damping[keep], modes.interface[keep], modes.line_of_sight[:, keep])
