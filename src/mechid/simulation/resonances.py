"""The resonances of a mechanism, from its own equations: it is linearised where friction holds it."""

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
from mechid.simulation.linearisation import Holding, Linearised, held_inputs, holdings, linearised, rotor_held

LEAST_HZ = 1e-3
"""What swings more slowly than this is a drift."""
OVERDAMPED = 0.999
"""A root with this damping ratio does not swing."""


@dataclass(frozen=True, kw_only=True)
class Resonance:
    """A resonance: what swings, its undamped frequency in Hz, and its damping ratio."""

    name: str
    frequency_hz: float
    damping: float = 0.0


def resonances(mechanism: Mechanism) -> tuple[Resonance, ...]:
    """Return what swings while friction holds the rotor and nothing else, the slowest first.

    The load on the gear is the first, sqrt(K_s / J_m) / 2 pi, 46.9 Hz with the estimates of [Kornienko2013]_ (section
    5.1), and with a housing that one's omega_0 / 2 pi. Each is named for the block whose states move most.

    A mechanism that has no place to rest, as one with values that are no numbers, has none.
    """
    plant = mechanism.plant
    found = _swinging(mechanism, held_inputs(plant), 0.0, rotor_held(plant))
    return tuple(r for r in found if r.name)


def free_resonances(mechanism: Mechanism, command: Command) -> tuple[Resonance, ...]:
    """Return what swings at the angle at which a command begins, the slowest first; friction holds nothing.

    The rotor on its motor's torque is among them, what the measuring chain adds is not: it moves no mechanism.
    """
    plant = mechanism.plant
    free = holdings(plant)[-1]
    found = _swinging(mechanism, held_inputs(plant, command), command.start_angle_rad, free, filtered=False)
    return tuple(found)


def _swinging(
    mechanism: Mechanism, inputs: FloatArray, theta_0: float, holding: Holding, *, filtered: bool = True
) -> list[Resonance]:
    """Return what swings where a mechanism is linearised, the slowest first, that of its filter or not."""
    plant = mechanism.plant
    try:
        about = linearised(plant, mechanism.kernel_values(), inputs, theta_0, holding)
    except FitError:
        return []
    words = _words(plant)
    found = []
    for value, shares in _roots(about):
        size, most = float(abs(value)), int(shares.argmax())
        swings = value.imag > 0.0 and size > 2.0 * math.pi * LEAST_HZ and -value.real < OVERDAMPED * size
        if swings and (filtered or most < len(plant.states)):
            found.append(
                Resonance(name=words[most], frequency_hz=size / (2.0 * math.pi), damping=-float(value.real) / size)
            )
    return sorted(found, key=lambda resonance: resonance.frequency_hz)


def _roots(about: Linearised) -> Iterator[tuple[complex, FloatArray]]:
    """Yield each eigenvalue with the share of each state in it, (n,): left times right eigenvector."""
    values, right = np.linalg.eig(about.matrices[0])
    left = np.linalg.pinv(right)
    for k, value in enumerate(values):
        yield complex(value), np.abs(left[k] * right[:, k])


def _words(plant: Plant) -> list[str]:
    """Return for each state, of the plant and then of its filter, what swings where it moves."""
    words: dict[sp.Symbol, str] = {}
    for block in plant.blocks:
        own = (*block.rates, *(block.filter.states if block.filter else ()))
        words |= dict.fromkeys(own, block.name) | dict(block.swinging)
    return [words[state] for state in (*plant.states, *plant.filter.states)]
