"""Initial values of mechanism files: the paper's catalogue, and an example of each other assembly."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mechid.plant.layout import STEPPER_GEAR_MASS


def _free(value: float, low: float, high: float) -> Mapping[str, float]:
    return {"value": value, "min": low, "max": high}


CATALOGUE: Mapping[str, Any] = {
    "stepper": {
        "poles": 100,
        "peak_voltage": 5.7,
        "rotor_inertia": 8.9e-6,
        "coil_resistance": _free(9.5, 5.0, 20.0),
        "coil_inductance": _free(0.0229, 0.005, 0.1),
        "torque_constant": _free(0.277, 0.1, 0.8),
        "detent": [
            {"period_deg": 1.8, "amplitude": _free(0.01, 0.0, 0.1), "phase_deg": _free(0.0, -180.0, 180.0)},
            {"period_deg": 3.6, "amplitude": _free(0.0, 0.0, 0.1), "phase_deg": _free(0.0, -180.0, 180.0)},
        ],
    },
    "friction": {
        "static": _free(0.03, 0.0, 0.1),
        "coulomb": _free(0.0265, 0.0, 0.1),
        "viscous": _free(9.74e-4, 0.0, 0.05),
    },
    "gear": {"ratio": 50, "stiffness": _free(2200.0, 300.0, 5000.0), "damping": _free(0.48, 0.02, 5.0)},
    "load": {"inertia": 0.010534},
    "housing": {
        "gain": _free(2.0, 0.1, 20.0),
        "frequency": _free(5000.0, 2500.0, 9000.0),
        "damping": _free(0.05, 0.005, 0.5),
    },
}
"""Content of a mechanism file: catalogue values of [Kornienko2013]_ with bounds; the peak voltage is assumed."""

_FRICTION: Mapping[str, Any] = {"coulomb": _free(0.005, 0.0, 0.05), "viscous": _free(1e-4, 0.0, 0.01)}
# Except for the paper's mechanism the numbers are made up, of the size of a small mechanism.
CATALOGUES: Mapping[str, Mapping[str, Any]] = {
    STEPPER_GEAR_MASS: CATALOGUE,
    "current_driven_stepper": {
        "stepper": {
            "poles": 100,
            "peak_current": 0.6,
            "rotor_inertia": 6e-5,
            "torque_constant": _free(0.3, 0.1, 0.8),
            "detent": [{"period_deg": 1.8, "amplitude": _free(0.01, 0.0, 0.1), "phase_deg": _free(0.0, -180.0, 180.0)}],
        },
        "friction": _FRICTION,
    },
    "direct_torque_drive": {
        "load": {"inertia": _free(1e-3, 1e-4, 1e-2)},
        "friction": _FRICTION,
        "drive": {"offset": _free(0.0, -0.1, 0.1)},
    },
    "direct_force_drive": {
        "load": {"mass": _free(100.0, 20.0, 300.0)},
        "friction": {"coulomb": _free(15.0, 0.0, 50.0), "viscous": _free(100.0, 0.0, 1000.0)},
        "drive": {"offset": _free(0.0, -20.0, 20.0)},
    },
    "two_mass_drive": {
        "motor": {"inertia": _free(1e-4, 1e-5, 1e-3)},
        "friction": _FRICTION,
        "gear": {"ratio": 100, "stiffness": _free(2000.0, 300.0, 10000.0), "damping": _free(0.5, 0.02, 5.0)},
        "load": {"inertia": _free(0.1, 0.01, 1.0)},
        "drive": {"offset": _free(0.0, -0.1, 0.1)},
    },
    "brushed_dc_drive": {
        "motor": {
            "inertia": _free(4e-5, 1e-5, 2e-4),
            "resistance": _free(2.3, 1.0, 5.0),
            "inductance": _free(1.5e-3, 3e-4, 6e-3),
            "torque_constant": _free(0.045, 0.02, 0.1),
        },
        "friction": _FRICTION,
        "drive": {"offset": 0.0},
    },
}
"""Example values by assembly."""
