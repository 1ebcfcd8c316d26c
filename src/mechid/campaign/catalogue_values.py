"""The numbers of the paper's catalogue, as a mechanism file holds them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


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
"""As a mechanism file: catalogue values of [Kornienko2013]_ (the peak voltage is not in it), with bounds."""
