"""Small-signal model of a flying mechanism: external actions as inputs, and the limits set by the supply.

Within its supply voltage, a voltage-limited current drive follows its command exactly, so for small signals it is
the ideal drive; the supply then sets a limit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import sympy as sp

from mechid.parameter import Role
from mechid.plant import chopper, current_limit
from mechid.plant.assembly import plant_of
from mechid.plant.flight import keeps_stand, moving_base_objection, with_base
from mechid.plant.layout import Base, Flying
from mechid.plant.mechanism import Mechanism
from mechid.plant.mechanisms import exported_quantities
from mechid.plant.moving_base import ACCELERATION
from mechid.plant.plant import Plant
from mechid.plant.ports import ADDED, PUSH, Port

_STANDS = "the mechanism stands on its bench, whose base is at rest"
UNITS: Mapping[str, str] = {
    PUSH.name: "N*m",
    ACCELERATION.name: "rad/s2",
    **{symbol.name: "V" if term.startswith("u") else "A" for term, symbol in ADDED.items()},
}
"""Units of the inputs that a mechanism may have for small signals."""


@dataclass(frozen=True)
class SmallSignal:
    """A mechanism with external actions as inputs.

    Attributes
    ----------
    mechanism : Mechanism
        In flight, on a rotating base if it can stand on one, or on its test stand; it outputs all its quantities.
    inputs : tuple of str
        Names of the plant's external inputs: additions in each phase, the torque on the output, the base's
        acceleration. Inputs driven by a command are not among them.
    driven : mapping of str to Symbol
        The plant's term that drives each phase, by the name of the input added to it.
    peak : mapping of str to float
        Largest magnitude that the supply gives each phase, by the name of that input, in its unit.
    objections : tuple of str
        Reasons for missing inputs, and limits of a current drive besides its peak, each a sentence.
    """

    mechanism: Mechanism
    inputs: tuple[str, ...]
    driven: Mapping[str, sp.Symbol]
    peak: Mapping[str, float]
    objections: tuple[str, ...]


def small_signal(flying: Mechanism) -> SmallSignal:
    """Return the small-signal model of a mechanism in flight, on a held base.

    Raises
    ------
    InputFileError
        A block of the user's own does not fit.
    """
    objection = _STANDS if keeps_stand(flying) else moving_base_objection(flying)
    on = flying if objection else with_base(flying, Flying(base=Base.DRIVEN))
    opened = _open(on)
    inputs = tuple(s.name for s in opened.plant.inputs if s.name in UNITS)
    driven = {ADDED[s.name].name: s for s, _ in opened.plant.terms if s.name in ADDED and ADDED[s.name].name in inputs}
    supply = opened.plant.names_with_role(Role.SUPPLY)
    peak = {name: opened.value(supply[0]) for name in driven} if supply else {}
    said = [f"The base's acceleration is no input: {objection}."] if objection else []
    if PUSH.name not in inputs:
        said.append(
            f'The torque on the output is no input: the load is a block of your own, and has no input "{PUSH.name}".'
        )
    return SmallSignal(opened, inputs, driven, peak, (*said, *_voltage_limit(flying)))


def _open(flying: Mechanism) -> Mechanism:
    """Return a mechanism with all ports and outputs, without tables that only limit its drive.

    On its test stand it has the layout of the bench: the stand's filters are then states of its own, and must not
    coexist with those of the filter for torque lines.
    """
    layout = flying.plant.layout
    assert layout is not None
    # Within its supply the limited drive is the ideal one.
    layout = replace(layout, ports=frozenset(Port), tables=layout.tables - {current_limit.TABLE, chopper.TABLE})
    if keeps_stand(flying):
        layout = replace(layout, flying=None)
    plant = plant_of(layout)
    plant = plant.with_outputs(exported_quantities(plant.offered))
    return Mechanism(plant, {name: flying.parameters[name] for name in plant.declarations}, flying.options)


def _voltage_limit(flying: Mechanism) -> list[str]:
    """Return the limit of a current drive as a sentence, if its supply is known."""
    if flying.plant.layout is None or current_limit.TABLE not in flying.plant.layout.tables:
        return []
    volts, ohms, henries = (flying.value(f"{current_limit.TABLE}.{d.key}") for d in current_limit.DECLARATIONS[:3])
    return [
        "The currents follow their command while the supply suffices: "
        f"|{ohms:.6g} ohm i + {henries:.6g} H di/dt + back-EMF| up to {volts:.6g} V in each phase."
    ]


def state_units(plant: Plant) -> dict[str, str]:
    """Return the unit of each state by name, as far as start values of records determine it."""
    units = {sp.Symbol(d.symbol): d.unit for block in plant.blocks for d in block.starts}
    return {
        str(state): units[symbol]
        for state, expr in plant.start_expressions.items()
        for symbol in sp.sympify(expr).free_symbols & units.keys()
        if sp.diff(expr, symbol) in (1, -1)
    }
