"""Layout of a mechanism as chosen in its file: assembly, laws, lists, optional tables and own blocks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum

from mechid.errors import InputFileError, did_you_mean
from mechid.plant.block import Block
from mechid.plant.ports import Port

STEPPER_GEAR_MASS = "stepper_gear_mass"
Parts = tuple[list[Block], dict[str, str], dict[str, str]]
"""Blocks, explicit wiring where names do not decide it, and quantities that can be measured."""


class Base(StrEnum):
    """Motion of the mechanism's base."""

    HELD = "held"
    """At rest, as on the bench; the torque on it is the blocked torque."""
    DRIVEN = "driven"
    """Its acceleration is an input of the plant."""
    ON_MODES = "on modes"
    """It moves with the modes of a structure, which are driven by the torque on it."""


@dataclass(frozen=True, kw_only=True)
class Flying:
    """Flight configuration of a mechanism.

    Attributes
    ----------
    base : Base
    modes : int
        Number of structural modes at the base.
    stand : bool
        Whether it stays on its test stand, driven by steps as in flight; the base is then held.
    """

    base: Base = Base.HELD
    modes: int = 0
    stand: bool = False


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Choices of a mechanism file.

    Attributes
    ----------
    assembly : str
    laws : mapping of str to str
        Law named in each table, e.g. ``{"friction": "stribeck"}``; missing tables have their default.
    orders : mapping of str to tuple of (int or None)
        Distinguishing number of each entry of a list of tables: periods per electrical period of the detents, orders of
        harmonics; one entry per flexible mode.
    tables : frozenset of str
        Optional tables that are present, e.g. ``"charge_amplifier"``.
    own : mapping of str to Block
        The user's own blocks, by the table whose library block they replace.
    flying : Flying or None
        Flight configuration; None on the bench.
    ports : frozenset of Port
        Ports at which external inputs act.
    phases : {2, 3, 4}
        Number of phases of the stepper.
    """

    assembly: str = STEPPER_GEAR_MASS
    laws: Mapping[str, str] = field(default_factory=dict)
    orders: Mapping[str, tuple[int | None, ...]] = field(default_factory=dict)
    tables: frozenset[str] = frozenset()
    own: Mapping[str, Block] = field(default_factory=dict)
    flying: Flying | None = None
    ports: frozenset[Port] = frozenset()
    phases: int = 2

    @property
    def turns(self) -> bool:
        """Whether the base moves."""
        return self.flying is not None and self.flying.base is not Base.HELD

    def law(self, table: str, known: Sequence[str], key: str = "law") -> str:
        """Return the law of a table, named by `key` in it, by default the first of `known`.

        Raises
        ------
        InputFileError
            The name is not in `known`.
        """
        name = self.laws.get(table, known[0])
        if name not in known:
            remedy = did_you_mean(name, known) or f"; known: {', '.join(known)}"
            raise InputFileError(f'{table}.{key}: unknown {key} "{name}"{remedy}')
        return name

    def count(self, table: str) -> int:
        """Return the number of entries of a list of tables."""
        return len(self.orders.get(table, ()))

    def whole_orders(self, table: str) -> tuple[int, ...]:
        """Return the orders of a list of tables in which every entry has one."""
        return tuple(order for order in self.orders.get(table, ()) if order)
