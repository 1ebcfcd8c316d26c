"""What a mechanism file chose of the library: assembly, laws, lists, optional tables, blocks of the user's own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from mechid.errors import InputFileError, did_you_mean
from mechid.plant.block import Block

STEPPER_GEAR_MASS = "stepper_gear_mass"
LIST_TABLES = ("stepper.detent", "stepper.torque_harmonic", "gear.kinematic_error", "load.mode")
"""Tables that are lists, ``[[name]]``."""
OWN_TABLES = ("friction", "gear", "load", "output_friction", "housing")
"""Tables whose block may be of the user's own."""


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
    """

    assembly: str = STEPPER_GEAR_MASS
    laws: Mapping[str, str] = field(default_factory=dict)
    orders: Mapping[str, tuple[int | None, ...]] = field(default_factory=dict)
    tables: frozenset[str] = frozenset()
    own: Mapping[str, Block] = field(default_factory=dict)

    def law(self, table: str, known: Sequence[str]) -> str:
        """Return the law of a table, the first of `known` where none is named.

        Raises
        ------
        InputFileError
            It is none of `known`.
        """
        name = self.laws.get(table, known[0])
        if name not in known:
            key = OPTION_KEYS.get(table, "law")
            remedy = did_you_mean(name, known) or f"; known: {', '.join(known)}"
            raise InputFileError(f'{table}.{key}: unknown {key} "{name}"{remedy}')
        return name

    def whole_orders(self, table: str) -> tuple[int, ...]:
        """Return the orders of a list of tables whose entries all have one."""
        return tuple(order for order in self.orders.get(table, ()) if order)


OPTION_KEYS: Mapping[str, str] = {"stepper": "drive", "housing": "form"}
"""The key by which a table chooses its block, where it is not ``law``."""
