"""The mechanism of these benches in SI units, angles in rad: the paper's estimates with other detent phases."""

import math
from collections.abc import Mapping

PHASES_DEG = (-62.0, 48.0)
VALUES: Mapping[str, float] = {
    "U": 5.7,
    "half_poles": 50.0,
    "J_rot": 8.9e-6,
    "R": 9.9,
    "L": 0.045,
    "k_m": 0.384,
    "detent_1": 0.0047,
    "detent_order_1": 200.0,
    "detent_phase_1": math.radians(PHASES_DEG[0]),
    "detent_2": 0.0231,
    "detent_order_2": 100.0,
    "detent_phase_2": math.radians(PHASES_DEG[1]),
    "static": 0.008,
    "coulomb": 0.0013,
    "viscous": 0.0061,
    "G": 50.0,
    "K_s": 913.47,
    "D": 0.39,
    "J_m": 0.010534,
    "K_res": 4.6,
    "w_0": 5578.0,
    "zeta": 0.095,
}
TRUTH: Mapping[str, float] = {
    "stepper.coil_resistance": VALUES["R"],
    "stepper.coil_inductance": VALUES["L"],
    "stepper.torque_constant": VALUES["k_m"],
    "stepper.detent.0.amplitude": VALUES["detent_1"],
    "stepper.detent.0.phase_deg": PHASES_DEG[0],
    "stepper.detent.1.amplitude": VALUES["detent_2"],
    "stepper.detent.1.phase_deg": PHASES_DEG[1],
    "friction.static": VALUES["static"],
    "friction.coulomb": VALUES["coulomb"],
    "friction.viscous": VALUES["viscous"],
    "gear.stiffness": VALUES["K_s"],
    "gear.damping": VALUES["D"],
    "housing.gain": VALUES["K_res"],
    "housing.frequency": VALUES["w_0"],
    "housing.damping": VALUES["zeta"],
}
"""What an identification is to find, by dotted name in the mechanism file's units."""
