"""Assembly of a layout into a plant: library blocks and the user's own, wired by name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

from sympy import Integer

from mechid.errors import InputFileError, did_you_mean
from mechid.plant.block import Block
from mechid.plant.drive import RAMP, measured_quantities
from mechid.plant.layout import Flying, Layout
from mechid.plant.mechanisms import ASSEMBLIES
from mechid.plant.moving_base import ACCELERATION
from mechid.plant.plant import Plant, assemble
from mechid.plant.ports import NAMES, Port


def check_assembly(name: str) -> None:
    """Raise InputFileError if there is no assembly of that name."""
    if name not in ASSEMBLIES:
        raise InputFileError(
            f'assembly: unknown "{name}"{did_you_mean(name, ASSEMBLIES) or "; known: " + ", ".join(ASSEMBLIES)}'
        )


def plant_of(layout: Layout) -> Plant:
    """Return the plant of a layout; it measures the first quantity that its assembly offers.

    Raises
    ------
    InputFileError
        The assembly or a law is unknown, or a block of the user's own does not fit.
    """
    check_assembly(layout.assembly)
    if layout.own:
        return _assemble(layout)
    # Own blocks are values of the user that need not be hashable: only layouts without them are cached.
    key = (tuple(sorted(layout.laws.items())), tuple(sorted(layout.orders.items())), tuple(sorted(layout.tables)))
    return _cached_plant(layout.assembly, *key, layout.flying, layout.ports, layout.phases)


@lru_cache(maxsize=64)
def _cached_plant(
    assembly: str,
    laws: tuple[tuple[str, str], ...],
    orders: tuple[tuple[str, tuple[int | None, ...]], ...],
    tables: tuple[str, ...],
    flying: Flying | None,
    ports: frozenset[Port],
    phases: int,
) -> Plant:
    return _assemble(
        Layout(
            assembly=assembly,
            laws=dict(laws),
            orders=dict(orders),
            tables=frozenset(tables),
            flying=flying,
            ports=ports,
            phases=phases,
        )
    )


def _assemble(layout: Layout) -> Plant:
    blocks, wiring, outputs = ASSEMBLIES[layout.assembly](layout)
    blocks = [_in_place(layout, block) for block in blocks]
    try:
        plant = assemble(layout.assembly, blocks, wiring, outputs)
    except ValueError as error:
        raise InputFileError(f"assembly: the blocks do not fit together: {error}") from error
    channels = measured_quantities(plant.inputs)
    # Inputs that no block supplies: the command, the base's motion, ports and measured channels.
    known = {"e_A", "e_B", ACCELERATION.name, *NAMES, *channels, *(f"{quantity}{RAMP}" for quantity in channels)}
    if unwired := [s.name for s in plant.inputs if s.name not in known]:
        names = ", ".join(name.removesuffix("_in") for name in unwired)
        raise InputFileError(f"assembly: no block gives {names}; a block of your own has to have it among its outputs")
    return replace(plant, layout=layout)


def _in_place(layout: Layout, block: Block) -> Block:
    """Return the user's own block in place of the library's, if the file names one for the block's table."""
    if block.name not in layout.own:
        return block
    own = layout.own[block.name]
    # A friction of the user's own that never holds the body need not declare `free`: it is 1 then.
    missing = {name: Integer(1) for name in block.outputs if name.startswith("free") and name not in own.outputs}
    return replace(own, name=block.name, table=own.table or block.table, outputs={**own.outputs, **missing})


def stepper_gear_mass(detent_orders: Sequence[int | None], housing_form: str | None) -> Plant:
    """Return the paper's mechanism (Fig. 2 of [Kornienko2013]_) as a plant.

    Parameters
    ----------
    detent_orders : sequence of int or None
        Periods per electrical period of each detent harmonic, None where not an integer.
    housing_form : str or None
        ``"paper"``, ``"unit_dc"``, or None for a rigid housing.
    """
    laws = {"housing": housing_form} if housing_form else {}
    return plant_of(Layout(laws=laws, orders={"stepper.detent": tuple(detent_orders)}, tables=frozenset(laws), own={}))
