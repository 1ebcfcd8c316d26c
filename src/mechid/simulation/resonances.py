"""Resonances of a mechanism, from its equations linearised where friction holds it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import sympy as sp

from mechid.arrays import FloatArray
from mechid.command import Command
from mechid.errors import FitError
from mechid.plant.mechanism import Mechanism
from mechid.plant.plant import Plant
from mechid.simulation.linearisation import Holding, Linearised, held_inputs, holdings, linearise, rotor_held

LEAST_HZ = 1e-3
"""A mode slower than this is a drift, not a resonance."""
OVERDAMPED = 0.999
"""A root with this damping ratio or more does not oscillate."""


@dataclass(frozen=True, kw_only=True)
class Resonance:
    """A resonance: name of the oscillating part, undamped frequency in Hz, and damping ratio."""

    name: str
    frequency_hz: float
    damping: float = 0.0


def resonances(mechanism: Mechanism) -> tuple[Resonance, ...]:
    """Return the resonances while friction holds the rotor and nothing else, in order of frequency.

    The first is the load on the gear, sqrt(K_s / J_m) / 2 pi, 46.9 Hz with the estimates of [Kornienko2013]_ (section
    5.1), and with a housing the housing's omega_0 / 2 pi. Each is named after the block whose states participate most.

    A mechanism without an equilibrium, such as one with values that are not numbers, has none.
    """
    plant = mechanism.plant
    found = _find_resonances(mechanism, held_inputs(plant), 0.0, rotor_held(plant))
    return tuple(r for r in found if r.name)


def free_resonances(mechanism: Mechanism, command: Command) -> tuple[Resonance, ...]:
    """Return the resonances at the start angle of a command, in order of frequency, without friction.

    The rotor on its motor's torque is among them. Modes of the measuring chain are left out: it moves no mechanism.
    """
    plant = mechanism.plant
    free = holdings(plant)[-1]
    found = _find_resonances(mechanism, held_inputs(plant, command), command.start_angle_rad, free, filtered=False)
    return tuple(found)


def _find_resonances(
    mechanism: Mechanism, inputs: FloatArray, theta_0: float, holding: Holding, *, filtered: bool = True
) -> list[Resonance]:
    """Return the resonances of the linearised mechanism in order of frequency, with or without those of its filter."""
    plant = mechanism.plant
    try:
        about = linearise(plant, mechanism.kernel_values(), inputs, theta_0, holding)
    except FitError:
        return []
    words = _words(plant)
    found = []
    for value, shares in _roots(about):
        size, most = float(abs(value)), int(shares.argmax())
        # Complex eigenvalues come in conjugate pairs, of which one is kept.
        swings = value.imag > 0.0 and size > 2.0 * math.pi * LEAST_HZ and -value.real < OVERDAMPED * size
        if swings and (filtered or most < len(plant.states)):
            found.append(
                Resonance(name=words[most], frequency_hz=size / (2.0 * math.pi), damping=-float(value.real) / size)
            )
    return sorted(found, key=lambda resonance: resonance.frequency_hz)


def _roots(about: Linearised) -> Iterator[tuple[complex, FloatArray]]:
    """Yield each eigenvalue with the participation of each state, (n,): left times right eigenvector."""
    values, right = np.linalg.eig(about.matrices[0])
    # A pseudo-inverse, since a mechanism free to drift may have a defective matrix.
    left = np.linalg.pinv(right)
    for k, value in enumerate(values):
        yield complex(value), np.abs(left[k] * right[:, k])


def _words(plant: Plant) -> list[str]:
    """Return the name of the oscillating part for each state, of the plant and then of its filter."""
    words: dict[sp.Symbol, str] = {}
    for block in plant.blocks:
        own = (*block.rates, *(block.filter.states if block.filter else ()))
        words |= dict.fromkeys(own, block.name) | dict(block.swinging)
    return [words[state] for state in (*plant.states, *plant.filter.states)]
