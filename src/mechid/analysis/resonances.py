"""The resonances that an estimate places in the records."""

from __future__ import annotations

import math
from dataclasses import dataclass

from mechid.plant.mechanism import Mechanism


@dataclass(frozen=True, kw_only=True)
class Resonance:
    """A resonance: what swings, and its undamped frequency in Hz."""

    name: str
    frequency_hz: float


def resonances(mechanism: Mechanism) -> tuple[Resonance, ...]:
    """Return the load's resonance on the gear with the rotor held, and the housing's where there is one.

    sqrt(K_s / J_m) / 2 pi, 46.9 Hz with the estimates of [Kornienko2013]_ (section 5.1), and omega_0 / 2 pi.
    A mechanism without the parameters has none.
    """
    has = mechanism.parameters.keys()
    found = []
    if {"gear.stiffness", "load.inertia"} <= has:
        squared = mechanism.value("gear.stiffness") / mechanism.value("load.inertia")
        found.append(Resonance(name="load on the gear", frequency_hz=math.sqrt(squared) / (2.0 * math.pi)))
    if "housing.frequency" in has:
        found.append(Resonance(name="housing", frequency_hz=mechanism.value("housing.frequency") / (2.0 * math.pi)))
    return tuple(found)
