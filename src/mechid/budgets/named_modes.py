"""Modes that orders of the step rate may meet."""

from __future__ import annotations

from mechid.budgets.flying_mechanism import Estimate
from mechid.simulation.resonances import resonances
from mechid.structure import Modes, Structure


def named_modes(structure: Structure, estimate: Estimate) -> list[tuple[str, float]]:
    """Return the modes that orders may cross: those of the mechanism with its rotor held and those of the structure."""
    named = [(r.name, r.frequency_hz) for r in resonances(estimate.mechanism)]
    if isinstance(structure.model, Modes):
        modes = structure.model
        named += [(f"structure {k}", float(f)) for k, f in enumerate(modes.frequency_hz) if not modes.rigid[k]]
    return named
