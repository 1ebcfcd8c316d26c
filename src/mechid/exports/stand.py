"""Choice of the exported mechanism: as in flight, or as on the bench with its test stand.

The default of all targets, as of the budget, is the mechanism in flight.
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


def describe_mechanism(bench: Mechanism, values: Mapping[str, float], *, stand: bool) -> str:
    """Describe the exported mechanism in one or two sentences.

    Parameters
    ----------
    bench : Mechanism
        Mechanism as identified.
    values : mapping of dotted name to float
        Changed values in the units of the mechanism file.
    stand : bool
        Whether to export the mechanism as on the bench.
    """
    changed = f" With {', '.join(f'{name} = {value:g}' for name, value in values.items())}." if values else ""
    if bench.plant.layout is None:
        return f"The mechanism as identified: it comes from no mechanism file that names a test stand.{changed}"
    left = _bench_tables(bench)
    if not left:
        return f"The mechanism as it flies, and as on the bench: it has no test stand.{changed}"
    tables = ", ".join(left)
    if stand:
        return f"The mechanism as on the bench, with {tables}; its base is at rest.{changed}"
    return f"The mechanism as it flies, without {tables}; --option {STAND}={YES} hands on the bench.{changed}"


def select_mechanism(bench: Mechanism, values: Mapping[str, float], *, stand: bool) -> Mechanism:
    """Return the exported mechanism, on a base at rest, with the outputs of the bench.

    Parameters
    ----------
    bench : Mechanism
        Mechanism as identified.
    values : mapping of dotted name to float
        Changed values in the units of the mechanism file.
    stand : bool
        Whether to export the mechanism as on the bench instead of as in flight.

    Raises
    ------
    InputFileError
        A value is missing or contradicts another.
    UsageError
        A parameter is unknown, or its value is impossible.
    """
    if stand or bench.plant.layout is None:
        refuse_values(values, bench.plant)
        return bench.with_values(values)
    refuse_values(values, without_stand(bench).plant)
    flying = without_stand(bench, values)
    return with_outputs(flying, [quantity for quantity in bench.plant.outputs if quantity in flying.plant.offered])


def with_outputs(mechanism: Mechanism, quantities: Sequence[str]) -> Mechanism:
    """Return a mechanism with other outputs.

    In flight a mechanism has a filter for its lines only. If no output uses the filter, it is removed with its
    parameters, which would have no effect.
    """
    plant, layout = mechanism.plant.with_outputs(quantities), mechanism.plant.layout
    if layout is not None and layout.flying is not None and LINE_TORQUE not in quantities:
        # In flight the filter serves the lines only, and would appear as a parameter without effect.
        idle = {table_of(name) for name in FILTER}
        plant = replace(plant, blocks=tuple(block for block in plant.blocks if block.table not in idle))
    return Mechanism(plant, {name: mechanism.parameters[name] for name in plant.declarations}, mechanism.options)


def read_stand(given: Mapping[str, str], also: Sequence[str] = ()) -> tuple[bool, dict[str, float]]:
    """Read the choice of the bench and the changed values from option strings of a target.

    Parameters
    ----------
    given : mapping of str to str
        Option strings, as ``{"stand": "yes", "load.inertia": "35"}``.
    also : sequence of str
        Further options of the target.

    Raises
    ------
    UsageError
        An option is unknown or has an invalid value.
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


def _bench_tables(bench: Mechanism) -> list[str]:
    """Return the tables that stay on the bench, without the drive of a measured channel."""
    driven = [f"[{DRIVE}]"] if measured_quantities(bench.plant.inputs) else []
    return [name for name in parts_left_on_bench(bench, ()) if name not in driven]
