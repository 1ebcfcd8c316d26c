"""Alternative laws and tables of a mechanism."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from mechid.plant.mechanism import Mechanism


@dataclass(frozen=True)
class Law:
    """An alternative law or table of a mechanism.

    Attributes
    ----------
    name : str
        Name of the alternative in a diagnosis, e.g. ``"friction.stribeck"``.
    mechanism : Mechanism
        The mechanism with the alternative.
    imitated_by : str
        The disturbance that mimics its absence; empty if none does.
    own : tuple of str
        Dotted names of its free parameters.
    null : str
        Dotted name of an amplitude at whose zero the effect vanishes, whatever its other parameters are; the derivative
        with respect to it shows whether the effect is present. Empty if there is none.
    size : str
        Dotted name of a size without a derivative at 0; at its lower bound the effect is absent. Empty if none.
    tries : tuple of mapping of str to float
        Values of its other parameters at which that derivative is evaluated; a fit of the alternative starts at the
        best of them. Empty if its own start suffices.
    hides : bool
        Whether a fit without it may leave nothing but noise and yet be wrong.
    """

    name: str
    mechanism: Mechanism
    imitated_by: str = ""
    own: tuple[str, ...] = ()
    null: str = ""
    size: str = ""
    tries: tuple[Mapping[str, float], ...] = ()
    hides: bool = False

    @property
    def entry_name(self) -> str:
        """Name in the entries of ``missing``, without the order, which the entry's table holds."""
        return self.name.partition(":")[0]

    def is_absent(self, mechanism: Mechanism) -> bool:
        """Return whether the effect's size in a mechanism is at its lower bound, within 1 %."""
        size = mechanism.parameters.get(self.size)
        return size is not None and size.value <= 1.01 * size.min

    def at_null(self, values: Mapping[str, float]) -> Mechanism:
        """Return the mechanism without the effect, its amplitude free and its other parameters held."""
        amplitude = self.mechanism.parameters[self.null]
        none = replace(amplitude, value=0.0, min=min(amplitude.min, 0.0))
        held = self.mechanism.with_values(values).with_parameters({self.null: none})
        return held.with_free((*(p.name for p in held.free if p.name not in self.own), self.null))

    def at(self, mechanism: Mechanism, amplitude: float) -> Mechanism:
        """Return the alternative's mechanism with another point's values and an amplitude, clipped to its bounds."""
        if not self.null:
            return mechanism
        known = self.mechanism.parameters
        others = {name: mechanism.value(name) for name in self.own if name != self.null}
        within = min(max(amplitude, known[self.null].min), known[self.null].max)
        return self.mechanism.with_values({**others, self.null: within})
