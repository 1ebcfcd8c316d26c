"""One law or table that may stand in place of what a mechanism has."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from mechid.plant.mechanism import Mechanism


@dataclass(frozen=True)
class Law:
    """A law or a table that may stand in place of what a mechanism has.

    Attributes
    ----------
    name : str
        As diagnosis calls it, e.g. ``"friction.stribeck"``.
    mechanism : Mechanism
        With it.
    imitated_by : str
        The disturbance that takes its place where it is lacking; empty where none does.
    own : tuple of str
        Dotted names of what is free of it.
    null : str
        Dotted name of an amplitude: where that is 0 there is nothing of it, whatever its other parameters are, and the
        derivative to it says whether there should be. Empty where it has none.
    tries : tuple of mapping of str to float
        Values of its other parameters at which that derivative is to be looked at: a fit of it begins at the best of
        them. Empty where its start will do.
    hides : bool
        Whether a fit without it may leave no more than noise and yet be wrong.
    """

    name: str
    mechanism: Mechanism
    imitated_by: str = ""
    own: tuple[str, ...] = ()
    null: str = ""
    tries: tuple[Mapping[str, float], ...] = ()
    hides: bool = False

    def at_null(self, values: Mapping[str, float]) -> Mechanism:
        """Return the mechanism where there is nothing of it, its amplitude free and its other parameters held."""
        amplitude = self.mechanism.parameters[self.null]
        none = replace(amplitude, value=0.0, min=min(amplitude.min, 0.0))
        held = self.mechanism.with_values(values).with_parameters({self.null: none})
        return held.with_free((*(p.name for p in held.free if p.name not in self.own), self.null))

    def at(self, mechanism: Mechanism, amplitude: float) -> Mechanism:
        """Return its mechanism with the other values of a point and an amplitude, as far as its bounds let it."""
        if not self.null:
            return mechanism
        known = self.mechanism.parameters
        others = {name: mechanism.value(name) for name in self.own if name != self.null}
        within = min(max(amplitude, known[self.null].min), known[self.null].max)
        return self.mechanism.with_values({**others, self.null: within})
