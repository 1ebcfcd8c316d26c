"""Periods that the library does not list, seen in what a model leaves of a record whose rate varies."""

from __future__ import annotations

from mechid.identification.diagnosis.candidate import Model
from mechid.identification.diagnosis.locked import locked
from mechid.plant.superset import extensions_at

NEAR = 1
"""Periods in a turn by which what is seen may be wrong: a record of few turns does not tell them better."""


def with_periods_seen(model: Model) -> Model | None:
    """Return a model, where it is, with further terms of the period that goes most with the motion; None without one.

    One whose kind is not looked for at all, as the campaign file has it, is none.
    """
    seen = max((one for one in locked(model) if one.orders), key=lambda one: one.share, default=None)
    if seen is None:
        return None
    kinds = {name.partition(":")[0] for name in model.setting.considered}
    known = {(e.name, str(e.structure)) for e in model.further}
    some = [
        e
        for e in extensions_at(model.base, seen.orders[0], NEAR)
        if e.name.partition(":")[0] in kinds and (e.name, str(e.structure)) not in known
    ]
    return model.with_further(some) if some else None
