"""How much the structure's motion changes the torque: the criterion, and the two-way joined model.

One-way, the torque of a held base goes through the transfer function. It suffices where the driving-point
receptance R times the mechanism's dynamic stiffness K is small, since the torque on a moving base is
T = T_held + K beta and beta = R T: |R K| << 1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mechid.plant.mechanism import Mechanism
from mechid.structure import Modes, Structure

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

SUFFICES = 0.05
"""|R K| up to which the one-way torque is taken for enough."""


def dynamic_stiffness(mechanism: Mechanism, frequency_hz: FloatArray, *, stuck: bool) -> ComplexArray:
    """Return torque on the base per base angle, (n,) N m/rad, of the mechanism linearised at holding.

    The rotor is stuck, or held by the magnetic stiffness (p/2) k_m U/R of the coils and viscous friction; the
    load is rigid.
    """
    v = {name: mechanism.value(name) for name in mechanism.parameters}
    w = 2.0 * np.pi * frequency_hz
    G, J, J_m = v["gear.ratio"], v["stepper.rotor_inertia"], v["load.inertia"]
    gear = (v["gear.stiffness"] + 1j * w * v["gear.damping"]) / G**2
    magnet = 0.5 * v["stepper.poles"] * v["stepper.torque_constant"] * v["stepper.peak_voltage"]
    rotor = magnet / v["stepper.coil_resistance"] + 1j * w * v["friction.viscous"] - w**2 * J + gear
    load = gear * G**2 - w**2 * J_m
    if stuck:
        a = np.zeros_like(w, dtype=np.complex128)
        g = w**2 * J_m / load
    else:
        determinant = rotor * load - (gear * G) ** 2
        a = (w**2 * J * load + gear * G * w**2 * J_m) / determinant
        g = (rotor * w**2 * J_m + gear * G * w**2 * J) / determinant
    return np.asarray(w**2 * (J * (1.0 + a) + J_m * (1.0 + g)), dtype=np.complex128)


def loop_gain(structure: Structure, mechanism: Mechanism, frequency_hz: FloatArray) -> FloatArray:
    """Return |R K| at each frequency, (n,), the larger of stuck and held rotor; NaN where R is not known."""
    receptance = structure.to_interface(frequency_hz)
    gains = [np.abs(receptance * dynamic_stiffness(mechanism, frequency_hz, stuck=s)) for s in (True, False)]
    return np.asarray(np.maximum(*gains), dtype=np.float64)


def largest_loop_gain(structure: Structure, mechanism: Mechanism, frequency_hz: FloatArray) -> float:
    """Return the largest |R K| at frequencies (n,) in Hz, NaN where R is known at none."""
    gains = loop_gain(structure, mechanism, frequency_hz)
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
