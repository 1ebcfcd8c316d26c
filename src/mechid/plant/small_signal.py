"""A flying mechanism opened for its small signals: what may act on it as inputs, and how far the supply lets it go.

A current drive that runs out of voltage follows its command exactly within its supply, so that for small signals it is
the ideal one; what its supply then allows is a limit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import sympy as sp

from mechid.parameter import Role
from mechid.plant import current_limit
from mechid.plant.assembly import plant_of
from mechid.plant.flight import keeps_stand, moving_base_objection, on_base
from mechid.plant.layout import Base, Flying
from mechid.plant.mechanism import Mechanism
from mechid.plant.mechanisms import LINE_TORQUE
from mechid.plant.moving_base import ACCELERATION
from mechid.plant.plant import Plant
from mechid.plant.ports import ADDED, PUSH, Port

_STANDS = "the mechanism stands on its bench, whose base is at rest"
UNITS: Mapping[str, str] = {
    PUSH.name: "N*m",
    ACCELERATION.name: "rad/s2",
    **{symbol.name: "V" if term.startswith("u") else "A" for term, symbol in ADDED.items()},
}
"""Of the inputs that a mechanism may have for small signals."""


@dataclass(frozen=True)
class SmallSignal:
    """A mechanism with what acts on it from outside as inputs.

    Attributes
    ----------
    mechanism : Mechanism
        In flight, on a base that turns where it can stand on one, or on its test stand; it measures all that it offers.
    inputs : tuple of str
        Names of the plant's inputs that act from outside: what is added in each phase, the torque on the output, the
        base's acceleration. Those that a command drives are not among them.
    driven : mapping of str to Symbol
        The plant's term of what drives each phase, by the name of the input that is added to it.
    peak : mapping of str to float
        The most that the supply gives each phase, either way, by the name of that input, in its unit.
    objections : tuple of str
        Why an input is lacking, and what limits a current drive beside its peak, each a sentence.
    """

    mechanism: Mechanism
    inputs: tuple[str, ...]
    driven: Mapping[str, sp.Symbol]
    peak: Mapping[str, float]
    objections: tuple[str, ...]


def small_signal(flying: Mechanism) -> SmallSignal:
    """Return a mechanism in flight, on a held base, opened for its small signals.

    Raises
    ------
    InputFileError
        A block of the user's own does not fit in.
    """
    objection = _STANDS if keeps_stand(flying) else moving_base_objection(flying)
    on = flying if objection else on_base(flying, Flying(base=Base.DRIVEN))
    opened = _opened(on)
    inputs = tuple(s.name for s in opened.plant.inputs if s.name in UNITS)
    driven = {ADDED[s.name].name: s for s, _ in opened.plant.terms if s.name in ADDED and ADDED[s.name].name in inputs}
    supply = opened.plant.having(Role.SUPPLY)
    peak = {name: opened.value(supply[0]) for name in driven} if supply else {}
    said = [f"The base's acceleration is no input: {objection}."] if objection else []
    if PUSH.name not in inputs:
        said.append(
            f'The torque on the output is no input: the load is a block of your own, and has no input "{PUSH.name}".'
        )
    return SmallSignal(opened, inputs, driven, peak, (*said, *_voltage_limit(flying)))


def _opened(flying: Mechanism) -> Mechanism:
    """Return a mechanism with all ports, without what only limits its drive; it measures all that it offers.

    On its test stand it is laid out as on the bench: the stand's filters are states of its own, and those of the filter
    before the lines must not stand beside them.
    """
    layout = flying.plant.layout
    assert layout is not None
    layout = replace(layout, ports=frozenset(Port), tables=layout.tables - {current_limit.TABLE})
    if keeps_stand(flying):
        layout = replace(layout, flying=None)
    plant = plant_of(layout)
    plant = plant.measuring([quantity for quantity in plant.offered if quantity != LINE_TORQUE])
    return Mechanism(plant, {name: flying.parameters[name] for name in plant.declarations}, flying.options)


def _voltage_limit(flying: Mechanism) -> list[str]:
    """Return what limits a current drive in a sentence, where its supply is known."""
    if flying.plant.layout is None or current_limit.TABLE not in flying.plant.layout.tables:
        return []
    volts, ohms, henries = (flying.value(f"{current_limit.TABLE}.{d.key}") for d in current_limit.DECLARATIONS[:3])
    return [
        "The currents follow their command while the supply suffices: "
        f"|{ohms:.6g} ohm i + {henries:.6g} H di/dt + back-EMF| up to {volts:.6g} V in each phase."
    ]


def state_units(plant: Plant) -> dict[str, str]:
    """Return the unit of each state, by its name, as far as its block says: by what a record may have of its own."""
    units = {sp.Symbol(d.symbol): d.unit for block in plant.blocks for d in block.starts}
    return {
        str(state): units[symbol]
        for state, expr in plant.begun.items()
        for symbol in sp.sympify(expr).free_symbols & units.keys()
        if sp.diff(expr, symbol) in (1, -1)
    }
