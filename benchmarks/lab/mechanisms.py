"""Mechanisms of whole lab benches: what is drawn, and the mechanism file that a careful engineer writes for it.

The mechanism is the paper's, scaled to a gear of another ratio, with one or two flexible modes of the load and a
kinematic error, on a table with a resonance and a low-pass filter.
"""

import math
from typing import Any

import numpy as np

from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.plant.mechanism import Mechanism
from recovery.mechanisms import drawn as motor_values
from recovery.mechanisms import paper_table

PAPER_RATIO = 50.0
RATIO = (50, 200)
LOAD_SHARE = (0.6, 1.8)
"""Inertia of the load seen at the rotor, over that of the paper's mechanism."""
ERROR_ORDERS, ERROR_RAD = (1, 2), (30e-6, 200e-6)
"""Kinematic error: orders per turn of the input, and size at the output of a gear of ratio 50; others are finer."""
MODES = (((10.0, 30.0), (0.1, 0.35)), ((70.0, 160.0), (0.03, 0.12)))
"""Of each mode of the load: frequency in Hz, and share of the load's inertia."""
MODE_DAMPING = (0.004, 0.015)
FE_FREQUENCY, FE_INERTIA = 0.05, 0.10
"""Standard deviations of a finite element model's frequencies and effective inertias: before a modal survey, usual."""
TABLE_HZ, TABLE_DAMPING = (200.0, 400.0), (0.01, 0.04)
FILTER_HZ, FILTER_ORDER = 3000.0, 4


def ratio_of(mechanism: Mechanism) -> float:
    """Return the gear ratio over that of the paper."""
    return mechanism.value("gear.ratio") / PAPER_RATIO


def modes_of(mechanism: Mechanism) -> int:
    """Return how many flexible modes the load has."""
    return sum(name.startswith("load.mode.") and name.endswith(".frequency") for name in mechanism.parameters)


def drawn_mechanism(seed: int) -> tuple[Mechanism, dict[str, float]]:
    """Return the mechanism as its file declares it, and the true values of what is free, in the file's units.

    The truth of the motor, of friction and gear lies about the catalogue as in the recovery benchmark, which is as the
    paper found its own: inductance up to 2.2 times, stiffness down to 0.39 times, Coulomb friction 1/26 to 1/2 of it.
    """
    rng = np.random.default_rng((seed, 0))
    ratio = int(rng.integers(RATIO[0], RATIO[1] + 1))
    scale = (ratio / PAPER_RATIO) ** 2 * rng.uniform(*LOAD_SHARE)
    table = paper_table()
    del table["housing"]
    table["gear"] |= {"ratio": ratio} | {key: _scaled(table["gear"][key], scale) for key in ("stiffness", "damping")}
    table["load"]["inertia"] *= scale
    truth = {name: value for name, value in motor_values(rng).items() if not name.startswith("housing.")}
    truth |= {name: truth[name] * scale for name in ("gear.stiffness", "gear.damping")}
    for add in (_add_kinematic_error, _add_modes, _add_table):
        truth |= add(table, rng)
    return mechanism_from_table(table, f"lab bench {seed}"), truth


def _scaled(entry: dict[str, float], scale: float) -> dict[str, float]:
    return {key: scale * number for key, number in entry.items()}


def _add_kinematic_error(table: dict[str, Any], rng: np.random.Generator) -> dict[str, float]:
    """Declare the gear's kinematic error by its data sheet, which says no phase; return the truth."""
    finer = PAPER_RATIO / table["gear"]["ratio"]
    order = int(rng.choice(ERROR_ORDERS))
    amplitude = {"value": 1e-4 * finer, "min": 0.0, "max": 5e-4 * finer}
    phase = {"value": 0.0, "min": -180.0, "max": 180.0}
    table["gear"]["kinematic_error"] = [{"order": order, "amplitude": amplitude, "phase_deg": phase}]
    name = "gear.kinematic_error.0"
    return {f"{name}.amplitude": finer * _log(rng, *ERROR_RAD), f"{name}.phase_deg": rng.uniform(-180.0, 180.0)}


def _add_modes(table: dict[str, Any], rng: np.random.Generator) -> dict[str, float]:
    """Declare one or two modes of the load as a finite element model gives them, with its sigmas; return the truth."""
    truth, modes = {}, []
    for number, (hz, share) in enumerate(MODES[: int(rng.integers(1, len(MODES) + 1))]):
        mode = {
            "frequency": 2.0 * math.pi * rng.uniform(*hz),
            "damping": _log(rng, *MODE_DAMPING),
            "inertia": table["load"]["inertia"] * rng.uniform(*share),
        }
        modes.append(
            {
                "frequency": _modelled(mode["frequency"], FE_FREQUENCY, rng),
                "damping": {"value": 0.01, "min": 0.001, "max": 0.05},
                "inertia": _modelled(mode["inertia"], FE_INERTIA, rng),
            }
        )
        truth |= {f"load.mode.{number}.{key}": value for key, value in mode.items()}
    table["load"]["mode"] = modes
    return truth


def _modelled(true: float, share: float, rng: np.random.Generator) -> dict[str, float]:
    """Return an entry of a model that is off by so much, with bounds at four of its sigmas."""
    value = true * (1.0 + share * float(np.clip(rng.standard_normal(), -2.0, 2.0)))
    return {
        "value": value,
        "min": value * (1.0 - 4.0 * share),
        "max": value * (1.0 + 4.0 * share),
        "sigma": share * value,
    }


def _add_table(table: dict[str, Any], rng: np.random.Generator) -> dict[str, float]:
    """Declare the table's resonance within a factor of 2 and the filter as it is set; return the truth."""
    table["transducer"] = {
        "law": "resonance",
        "frequency": {"value": 2.0 * math.pi * 300.0, "min": 2.0 * math.pi * 150.0, "max": 2.0 * math.pi * 600.0},
        "damping": {"value": 0.02, "min": 0.002, "max": 0.2},
    }
    table["anti_alias"] = {"order": FILTER_ORDER, "frequency": 2.0 * math.pi * FILTER_HZ}
    return {
        "transducer.frequency": 2.0 * math.pi * rng.uniform(*TABLE_HZ),
        "transducer.damping": _log(rng, *TABLE_DAMPING),
    }


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return math.exp(rng.uniform(math.log(low), math.log(high)))
