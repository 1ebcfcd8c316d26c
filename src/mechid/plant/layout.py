"""Layout of a mechanism: assembly, laws, lists, optional tables and own blocks, as its file chose them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum

from mechid.errors import InputFileError, did_you_mean
from mechid.plant.block import Block
from mechid.plant.ports import Port

STEPPER_GEAR_MASS = "stepper_gear_mass"


class Base(StrEnum):
    """What the mechanism's base does."""

    HELD = "held"
    """It does not move, as on the bench; the torque on it is the blocked one."""
    DRIVEN = "driven"
    """Its acceleration is an input of the plant."""
    ON_MODES = "on modes"
    """It moves with the modes of a structure, which the torque on it drives."""


@dataclass(frozen=True, kw_only=True)
class Flying:
    """How a mechanism flies.

    Attributes
    ----------
    base : Base
    modes : int
        Of the structure at the base.
    stand : bool
        Whether it stays on its test stand, driven by steps as in flight; the base is held then.
    """

    base: Base = Base.HELD
    modes: int = 0
    stand: bool = False


@dataclass(frozen=True, kw_only=True)
class Layout:
    """What a mechanism file chose.

    Attributes
    ----------
    assembly : str
    laws : mapping of str to str
        Table to the law named in it, e.g. ``{"friction": "stribeck"}``; a table that is absent has its default.
    orders : mapping of str to tuple of (int or None)
        List of tables to what tells its entries apart: periods per electrical period of the detents, orders of
        harmonics, one entry for each flexible mode.
    tables : frozenset of str
        Optional tables that are there, e.g. ``"charge_amplifier"``.
    own : mapping of str to Block
        Table to the user's own block in place of those of the library.
    flying : Flying or None
        How it flies; None on the bench.
    ports : frozenset of Port
        Where something from outside acts on it.
    """

    assembly: str = STEPPER_GEAR_MASS
    laws: Mapping[str, str] = field(default_factory=dict)
    orders: Mapping[str, tuple[int | None, ...]] = field(default_factory=dict)
    tables: frozenset[str] = frozenset()
    own: Mapping[str, Block] = field(default_factory=dict)
    flying: Flying | None = None
    ports: frozenset[Port] = frozenset()

    @property
    def turns(self) -> bool:
        """Whether the base moves."""
        return self.flying is not None and self.flying.base is not Base.HELD

    def law(self, table: str, known: Sequence[str], key: str = "law") -> str:
        """Return the law of a table, named by `key` there, the first of `known` where none is named.

        Raises
        ------
        InputFileError
            It is none of `known`.
        """
        name = self.laws.get(table, known[0])
        if name not in known:
            remedy = did_you_mean(name, known) or f"; known: {', '.join(known)}"
            raise InputFileError(f'{table}.{key}: unknown {key} "{name}"{remedy}')
        return name

    def whole_orders(self, table: str) -> tuple[int, ...]:
        """Return the orders of a list of tables whose entries all have one."""
        return tuple(order for order in self.orders.get(table, ()) if order)
