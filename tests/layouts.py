"""Mechanisms of the block library, as the tests use them: the paper's file with some of its tables changed."""

import copy
from collections.abc import Mapping
from pathlib import Path

from mechid.campaign import mechanism_from_table
from paper import ESTIMATED

SINGLE_STEPPER = {
    "stepper": {
        "poles": 100,
        "peak_current": 0.6,
        "torque_constant": 0.384,
        "rotor_inertia": 6e-5,
        "detent": [{"period_deg": 1.8, "amplitude": 0.0231, "phase_deg": 35.0}],
    },
    "friction": {"static": 0.008, "coulomb": 0.006, "viscous": 5e-4},
}

BRUSHED_DC = {
    "motor": {"inertia": 4e-5, "resistance": 2.3, "inductance": 1.5e-3, "torque_constant": 0.045},
    "friction": {"static": 6e-3, "coulomb": 5e-3, "viscous": 2e-5},
    "drive": {"offset": 0.02},
}


def paper_table():
    """Return the paper's estimates as a mechanism file holds them."""
    table = {}
    for name, value in ESTIMATED.items():
        *path, key = name.split(".")
        if path[1:2] != ["detent"]:
            table.setdefault(path[0], {})[key] = value
    table["stepper"]["detent"] = [
        {key: ESTIMATED[f"stepper.detent.{k}.{key}"] for key in ("period_deg", "amplitude", "phase_deg")}
        for k in (0, 1)
    ]
    return table


def changed(table: Mapping, changes: Mapping):
    """Return a table with others put over it, depth first; None takes an entry away."""
    out = copy.deepcopy(dict(table))
    for key, value in changes.items():
        if value is None:
            out.pop(key, None)
        elif isinstance(value, Mapping) and isinstance(out.get(key), Mapping):
            out[key] = changed(out[key], value)
        else:
            out[key] = copy.deepcopy(value)
    return out


def paper_with(changes: Mapping, folder: Path = Path()):
    """Return the paper's mechanism with tables of its file changed."""
    return mechanism_from_table(changed(paper_table(), changes), "mechanism.toml", folder)


def mechanism_of(table: Mapping):
    """Return the mechanism of a table."""
    return mechanism_from_table(table, "mechanism.toml")


LAYOUTS = {
    "stribeck": {"friction": {"law": "stribeck", "coulomb": 0.004, "stribeck_rate": 2.0}},
    "directional": {"friction": {"law": "directional", "coulomb": 0.004, "asymmetry": 0.2, "viscous_asymmetry": -0.1}},
    "load_dependent": {"friction": {"law": "load_dependent", "coulomb": 0.003, "load_share": 0.06}},
    "lugre": {
        "friction": {
            "law": "lugre",
            "coulomb": 0.004,
            "stribeck_rate": 2.0,
            "bristle_stiffness": 4.0,
            "bristle_damping": 1e-3,
        }
    },
    "friction position": {
        "friction": {
            "coulomb": 0.004,
            "position": [
                {"order": 1, "amplitude": 0.3, "phase_deg": 70.0},
                {"order": 2, "amplitude": 0.15, "phase_deg": -20.0},
            ],
            "output_position": [{"order": 1, "amplitude": 0.1, "phase_deg": 10.0}],
        }
    },
    "friction by direction": {
        "friction": {
            "coulomb": 0.004,
            "position": [{"order": 1, "amplitude": 0.2, "phase_deg": 70.0}],
            "position_forward": [
                {"order": 1, "amplitude": 0.1, "phase_deg": 10.0},
                {"order": 2, "amplitude": 0.15, "phase_deg": -20.0},
            ],
            "position_backward": [{"order": 2, "amplitude": 0.3, "phase_deg": 130.0}],
        }
    },
    "piecewise_linear": {
        "gear": {
            "stiffness": None,
            "law": "piecewise_linear",
            "stiffness_1": 400.0,
            "stiffness_2": 900.0,
            "stiffness_3": 1300.0,
            "torque_1": 0.08,
            "torque_2": 0.25,
        }
    },
    "backlash": {"gear": {"law": "backlash", "backlash": 2e-4}},
    "kinematic_error": {
        "gear": {
            "kinematic_error": [
                {"order": 2, "amplitude": 1e-4, "phase_deg": 20.0},
                {"order": 4, "amplitude": 4e-5, "phase_deg": -70.0},
            ]
        }
    },
    "tooth mesh": {
        "gear": {
            "mesh": [{"teeth": [74, 69]}, {"teeth": [75, 80], "ratio_behind": 50.2717391304}],
            "kinematic_error": [
                {"order": "mesh 1", "amplitude": 2e-5, "phase_deg": 20.0},
                {"order": "mesh 2", "amplitude": 1e-5, "phase_deg": -70.0},
                {"order": 2, "amplitude": 1e-4, "phase_deg": 45.0},
            ],
            "stiffness_variation": [{"order": "mesh 2", "amplitude": 0.2, "phase_deg": 100.0}],
        }
    },
    "output_friction": {"output_friction": {"coulomb": 0.05, "stiction": 0.02, "viscous": 0.01}},
    "flexible load": {
        "load": {
            "mode": [
                {"frequency": 190.0, "damping": 0.01, "inertia": 0.003},
                {"frequency": 700.0, "damping": 0.02, "inertia": 0.001},
            ]
        }
    },
    "unbalance": {"load": {"unbalance": {"amplitude": 0.08, "phase_deg": 30.0}}},
    "cable spring": {"load": {"cable": {"stiffness": 0.4, "rest_angle": 0.1}}},
    "cable": {
        "load": {
            "cable": {"law": "dahl", "stiffness": 0.4, "rest_angle": 0.1, "hysteresis": 0.03, "hysteresis_angle": 2e-3}
        }
    },
    "imbalance": {
        "stepper": {
            "imbalance": {
                "resistance": 0.02,
                "inductance": -0.03,
                "torque_constant": 0.04,
                "offset_a": 0.1,
                "offset_b": -0.05,
            }
        }
    },
    "detent hysteresis": {"stepper": {"detent_hysteresis": {"torque": 0.004, "angle_deg": 20.0}}},
    "magnet": {"stepper": {"magnet": {"temperature_rise": 40.0, "detent_per_K": -2e-3}}},
    "saliency": {"stepper": {"saliency": {"share": 0.08}}},
    "torque_harmonic": {
        "stepper": {
            "torque_harmonic": [
                {"order": 3, "amplitude": 0.05, "phase_deg": 30.0},
                {"order": 5, "amplitude": 0.02, "phase_deg": -50.0},
            ]
        }
    },
    "microstep table": {
        "stepper": {
            "microstep_table": [
                {"order": 2, "amplitude": 0.03, "phase_deg": 40.0},
                {"order": 4, "amplitude": 0.05, "phase_deg": -25.0},
            ]
        }
    },
    "second mode": {"housing": {"second_mode": {"gain": 0.8, "frequency": 2500.0, "damping": 0.04}}},
    "supply": {"supply": {"resistance": 1.4}},
    "current drive": {
        "stepper": {
            "drive": "current",
            "peak_current": 0.5,
            "peak_voltage": None,
            "coil_resistance": None,
            "coil_inductance": None,
            "back_emf_constant": None,
        }
    },
    "current limit": {
        "stepper": {
            "drive": "current",
            "peak_current": 0.5,
            "peak_voltage": None,
            "coil_resistance": None,
            "coil_inductance": None,
            "back_emf_constant": None,
            "current_limit": {"voltage": 12.0, "resistance": 9.9, "inductance": 0.045},
        }
    },
    "test stand": {
        "transducer": {"law": "adaptor", "gain": -1.1, "stiffness": 2.0e4, "adaptor_inertia": 1e-4, "damping": 0.02},
        "charge_amplifier": {"time_constant": 0.8},
        "anti_alias": {"frequency": 22000.0, "order": 5},
    },
    "three switches": {
        "friction": {"coulomb": 0.004},
        "gear": {"law": "backlash", "backlash": 2e-4},
        "output_friction": {"coulomb": 0.05, "stiction": 0.02, "viscous": 0.01},
    },
}
"""Changes to the paper's file, one for each block of the library, and several switching blocks at once."""
