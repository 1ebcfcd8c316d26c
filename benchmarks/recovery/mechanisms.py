"""Families of mechanisms: what is drawn, and the catalogue from which each is identified."""

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
    """Mechanisms that one catalogue describes; each draw is a truth within the family's ranges.

    `stepped` is how a driver of the family goes through a step finer than a full one: "micro", "half", or not at all.
    """

    number: int
    table: Callable[[], dict[str, Any]]
    draw: Callable[[np.random.Generator], Mapping[str, float]]
    stepped: str = "micro"

    def catalogue(self) -> Mechanism:
        """Return the catalogue, its unknown parameters free."""
        return mechanism_from_table(self.table(), f"catalogue of family {self.number}")

    def truth(self, seed: int) -> Mechanism:
        """Return the mechanism of a seed."""
        return self.catalogue().with_values(self.draw(np.random.default_rng((self.number, seed))))


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


def star_table() -> dict[str, Any]:
    """Return a three-phase motor in star with the paper's pole pairs: full steps of 1.2 degrees."""
    table = paper_table()
    table["stepper"] |= {"phases": 3, "connection": "star"}
    for detent, period in zip(table["stepper"]["detent"], (1.2, 2.4), strict=True):
        detent["period_deg"] = period
    return table


def unipolar_table() -> dict[str, Any]:
    """Return a motor of four phases, one half winding each."""
    table = paper_table()
    table["stepper"] |= {"phases": 4, "connection": "unipolar"}
    return table


def pulsed_table() -> dict[str, Any]:
    """Return a bipolar motor fed for 5 ms a step, its phases then open but for clamping diodes at 6 V.

    Between pulses the detent of a full step holds the rotor; that of two steps has a tenth of the paper's range, or the
    rotor would fall into every second step.
    """
    table = paper_table()
    clamp = {"value": 6.0, "min": 2.0, "max": 20.0}
    table["stepper"]["pulses"] = {"on_s": 0.005, "between": "open", "clamp_V": clamp, "diode_drop_V": 0.7}
    return table


def drawn_pulsed(rng: np.random.Generator) -> Mapping[str, float]:
    """Draw the 16 unknown parameters of a pulsed motor."""
    values = dict(drawn(rng))
    values["stepper.detent.1.amplitude"] *= 0.1
    values["stepper.pulses.clamp_V"] = rng.uniform(3.0, 12.0)
    return values


FAMILIES = {
    1: Family(1, paper_table, drawn),
    2: Family(2, fine_stepped_table, drawn),
    3: Family(3, star_table, drawn),
    4: Family(4, unipolar_table, drawn, stepped="half"),
    5: Family(5, pulsed_table, drawn_pulsed, stepped="full"),
}
