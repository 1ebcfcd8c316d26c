"""Ports: external actions on a mechanism, as inputs of its plant in addition to those that drive it.

A voltage added in each phase, at its terminals, or a current if currents are commanded; and a torque on the
output. The torque on the output acts in inertial space: the base feels it only through gear and friction.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from enum import StrEnum

from sympy import Symbol

from mechid.plant.block import Block


class Port(StrEnum):
    """External actions on a mechanism."""

    PHASES = "phases"
    """A voltage, or a current, added in each phase."""
    OUTPUT = "output"
    """A torque on the output, N m."""


PUSH = Symbol("output_torque")
ADDED: Mapping[str, Symbol] = {
    f"{letter}_{x}": Symbol(f"added_{word}_phase_{x.lower()}")
    for letter, word in (("u", "voltage"), ("i", "current"))
    for x in "AB"
}
"""Input added to each term that a drive may have: V to a voltage, A to a current."""
NAMES = frozenset({PUSH.name, *(symbol.name for symbol in ADDED.values())})
"""Names of the plant's inputs that are ports."""


def add_phase_ports(drive: Block) -> Block:
    """Return a drive of voltages or currents with an external input added in each phase."""
    added = {symbol: ADDED[symbol.name] for symbol in drive.terms if symbol.name in ADDED}
    terms = {symbol: e + added.get(symbol, 0) for symbol, e in drive.terms.items()}
    return replace(drive, inputs=(*drive.inputs, *added.values()), terms=terms)
