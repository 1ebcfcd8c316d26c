"""Effect of the structure's motion on the torque: the criterion, and the two-way joined model.

One-way, the torque of a held base goes through the transfer function. It suffices where the driving-point
receptance R times the mechanism's dynamic stiffness K is small, since the torque on a moving base is
T = T_held + K beta and beta = R T: |R K| << 1. K comes from the plant's own equations, its base driven.
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
    """Return torque on the base per base angle, (h, n) N m/rad, of the mechanism linearised where it holds.

    Each row is for one way in which the switches may hold: friction sticks or slides, a gear is within its play or in
    contact (`simulation.linearisation.holdings`); which of them holds in motion is not known beforehand.

    Parameters
    ----------
    mechanism : Mechanism
        In flight, on a held base.
    frequency_hz : (n,)
        Above 0.
    command : Command or None
        Whose start the coils hold; None is a full step at angle 0.

    Raises
    ------
    InputFileError
        A block of the user's own does not say how it moves with its base.
    FitError
        There is no equilibrium near the commanded angle.
    """
    driven = with_base(mechanism, Flying(base=Base.DRIVEN))
    plant, p = driven.plant, driven.kernel_values()
    inputs, at = held_inputs(plant, command), plant.inputs.index(ACCELERATION)
    angle = command.start_angle_rad if command else 0.0
    square = (2.0 * np.pi * frequency_hz) ** 2
    rows = [linearise(plant, p, inputs, angle, how).response(frequency_hz)[:, 0, at] for how in holdings(plant)]
    return np.asarray(-square * np.array(rows), dtype=np.complex128)


def loop_gain(
    structure: Structure, mechanism: Mechanism, frequency_hz: FloatArray, command: Command | None = None
) -> FloatArray:
    """Return |R K| at each frequency, (n,), the largest of the ways to hold; NaN where R or K is not known."""
    receptance = structure.to_interface(frequency_hz)
    if moving_base_objection(mechanism):
        return np.full(frequency_hz.size, np.nan)
    gains = np.abs(receptance * dynamic_stiffness(mechanism, frequency_hz, command))
    return np.asarray(gains.max(axis=0), dtype=np.float64)


def largest_loop_gain(
    structure: Structure, mechanism: Mechanism, frequency_hz: FloatArray, command: Command | None = None
) -> float:
    """Return the largest |R K| at frequencies (n,) in Hz, NaN where R or K is known at none."""
    gains = loop_gain(structure, mechanism, frequency_hz, command)
    known = gains[np.isfinite(gains)]
    return float(known.max()) if known.size else float("nan")


def coupled_modes(structure: Structure, below_hz: float) -> Modes | None:
    """Return the modes that are joined with the mechanism; None where the structure has none to join."""
    if not isinstance(structure.model, Modes):
        return None
    modes = structure.model
    keep = (modes.frequency_hz <= below_hz) & (modes.interface != 0.0)
    if not keep.any():
        return None
    return Modes(modes.frequency_hz[keep], modes.damping[keep], modes.interface[keep], modes.line_of_sight[:, keep])
