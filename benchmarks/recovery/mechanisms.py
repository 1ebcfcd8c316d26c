"""Two families of mechanisms: what is drawn, and the catalogue from which each is identified."""

import copy
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.plant.mechanism import Mechanism


@dataclass(frozen=True)
class Family:
    """Mechanisms that one catalogue describes; each draw is a truth within the family's ranges."""

    number: int
    table: Callable[[], dict[str, Any]]

    def catalogue(self) -> Mechanism:
        """Return the catalogue, its 15 unknown parameters free."""
        return mechanism_from_table(self.table(), f"catalogue of family {self.number}")

    def truth(self, seed: int) -> Mechanism:
        """Return the mechanism of a seed."""
        return self.catalogue().with_values(drawn(np.random.default_rng((self.number, seed))))


def drawn(rng: np.random.Generator) -> Mapping[str, float]:
    """Draw the 15 unknown parameters, in the mechanism file's units."""

    def log_uniform(low: float, high: float) -> float:
        return math.exp(rng.uniform(math.log(low), math.log(high)))

    coulomb = log_uniform(1e-3, 15e-3)
    return {
        "stepper.coil_resistance": 9.5 * rng.uniform(0.95, 1.1),
        "stepper.coil_inductance": 0.0229 * log_uniform(0.8, 2.2),
        "stepper.torque_constant": 0.277 * rng.uniform(0.9, 1.45),
        "stepper.detent.0.amplitude": rng.uniform(2e-3, 12e-3),
        "stepper.detent.0.phase_deg": rng.uniform(-180.0, 180.0),
        "stepper.detent.1.amplitude": rng.uniform(2e-3, 25e-3),
        "stepper.detent.1.phase_deg": rng.uniform(-180.0, 180.0),
        "friction.coulomb": coulomb,
        "friction.static": coulomb + rng.uniform(2e-3, 8e-3),
        "friction.viscous": log_uniform(8e-4, 7e-3),
        "gear.stiffness": rng.uniform(850.0, 2300.0),
        "gear.damping": log_uniform(0.25, 0.9),
        "housing.gain": rng.uniform(2.5, 6.0),
        "housing.frequency": rng.uniform(4600.0, 6400.0),
        "housing.damping": rng.uniform(0.04, 0.12),
    }


def paper_table() -> dict[str, Any]:
    """Return the catalogue of the paper's mechanism, as a mechanism file."""
    return copy.deepcopy(dict(CATALOGUE))


def fine_stepped_table() -> dict[str, Any]:
    """Return another machine: 200 poles, three times the load, and bounds two to four times as wide.

    A full step is 180/200 = 0.9 degrees; the detents have the periods of one and of two full steps, as the
    paper's have. Catalogue values of what is unknown are the paper's.
    """
    table = paper_table()
    stepper, friction = table["stepper"], table["friction"]
    stepper["poles"] = 200
    table["load"]["inertia"] *= 3.0
    bounds = {
        "coil_resistance": (stepper, 3.0, 40.0),
        "coil_inductance": (stepper, 0.002, 0.3),
        "torque_constant": (stepper, 0.04, 2.0),
        "static": (friction, 0.0, 0.3),
        "coulomb": (friction, 0.0, 0.3),
        "viscous": (friction, 0.0, 0.15),
        "stiffness": (table["gear"], 100.0, 15000.0),
        "damping": (table["gear"], 0.01, 15.0),
        "gain": (table["housing"], 0.05, 50.0),
        "frequency": (table["housing"], 2000.0, 12000.0),
    }
    for key, (owner, low, high) in bounds.items():
        owner[key] |= {"min": low, "max": high}
    for detent, period in zip(stepper["detent"], (0.9, 1.8), strict=True):
        detent["period_deg"] = period
        detent["amplitude"] |= {"max": 0.3}
    return table


FAMILIES = {1: Family(1, paper_table), 2: Family(2, fine_stepped_table)}
