"""Which mechanism is handed on: as it flies, or as it stood on the bench, with what the test stand adds.

All targets take the same by default, as budget and tables do: the one that flies.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from mechid.errors import UsageError
from mechid.exports.option_texts import NO, YES, refuse_unknown, refuse_values, yes_or_no
from mechid.plant.drive import measured_quantities
from mechid.plant.flight import DRIVE, FILTER, parts_left_on_bench, without_stand
from mechid.plant.mechanism import Mechanism
from mechid.plant.mechanisms import LINE_TORQUE
from mechid.plant.tables import table_of

STAND = "stand"


def which_mechanism(bench: Mechanism, values: Mapping[str, float], *, stand: bool) -> str:
    """Return which mechanism is handed on, in a sentence or two.

    Parameters
    ----------
    bench : Mechanism
        As identified.
    values : mapping of dotted name to float
        What differs, in the mechanism file's units.
    stand : bool
        Whether it is handed on as on the bench.
    """
    changed = f" With {', '.join(f'{name} = {value:g}' for name, value in values.items())}." if values else ""
    if bench.plant.layout is None:
        return f"The mechanism as identified: it comes from no mechanism file that names a test stand.{changed}"
    left = _left(bench)
    if not left:
        return f"The mechanism as it flies, and as on the bench: it has no test stand.{changed}"
    tables = ", ".join(left)
    if stand:
        return f"The mechanism as on the bench, with {tables}; its base is at rest.{changed}"
    return f"The mechanism as it flies, without {tables}; --option {STAND}={YES} hands on the bench.{changed}"


def handed_on(bench: Mechanism, values: Mapping[str, float], *, stand: bool) -> Mechanism:
    """Return the mechanism that is handed on, on a base at rest; it measures what the bench's does.

    Parameters
    ----------
    bench : Mechanism
        As identified.
    values : mapping of dotted name to float
        What differs, in the mechanism file's units.
    stand : bool
        Whether it is taken as on the bench, in place of as it flies.

    Raises
    ------
    InputFileError
        A value is missing or contradicts another.
    UsageError
        A value is of no parameter, or cannot be.
    """
    if stand or bench.plant.layout is None:
        refuse_values(values, bench.plant)
        return bench.with_values(values)
    refuse_values(values, without_stand(bench).plant)
    flying = without_stand(bench, values)
    return measuring(flying, [quantity for quantity in bench.plant.outputs if quantity in flying.plant.offered])


def measuring(mechanism: Mechanism, quantities: Sequence[str]) -> Mechanism:
    """Return a mechanism with other outputs.

    The filter that a flying one has for its lines alone is left out with its parameters where no output sees it: it is
    none of the bench's, and would stand among the parameters with no effect.
    """
    plant, layout = mechanism.plant.with_outputs(quantities), mechanism.plant.layout
    if layout is not None and layout.flying is not None and LINE_TORQUE not in quantities:
        idle = {table_of(name) for name in FILTER}
        plant = replace(plant, blocks=tuple(block for block in plant.blocks if block.table not in idle))
    return Mechanism(plant, {name: mechanism.parameters[name] for name in plant.declarations}, mechanism.options)


def read_stand(given: Mapping[str, str], also: Sequence[str] = ()) -> tuple[bool, dict[str, float]]:
    """Return whether the bench is asked for, and what differs, from the texts of a target's options.

    Parameters
    ----------
    given : mapping of str to str
        As ``{"stand": "yes", "load.inertia": "35"}``.
    also : sequence of str
        Further options of the target.

    Raises
    ------
    UsageError
        There is no such option, or its text is none of it.
    """
    values = {}
    for name, text in given.items():
        if "." not in name:
            refuse_unknown(name, [STAND, *also], also=", and dotted names of parameters")
            continue
        try:
            values[name] = float(text)
        except ValueError:
            values[name] = math.nan
        if not math.isfinite(values[name]):
            raise UsageError(f'--option {name}: found "{text}"; write a number')
    return yes_or_no(STAND, given.get(STAND, NO)), values


def _left(bench: Mechanism) -> list[str]:
    """Return the tables that stay on the bench; what drives it by a measured channel goes with it."""
    driven = [f"[{DRIVE}]"] if measured_quantities(bench.plant.inputs) else []
    return [name for name in parts_left_on_bench(bench, ()) if name not in driven]
