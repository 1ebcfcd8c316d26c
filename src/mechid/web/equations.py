"""Equations that contain a parameter, as MathML, computed on request."""

from __future__ import annotations

from mechid.kernel.equation_text import equations_with
from mechid.plant.plant import Plant


class Equations:
    """Equations of one plant by parameter, shared by all tabs."""

    def __init__(self, plant: Plant) -> None:
        self.plant = plant
        self._known: dict[str, list[tuple[str, str]]] = {}

    def of(self, name: str) -> list[tuple[str, str]]:
        """Return the sides of the equations that contain a parameter of the file, as MathML."""
        # Deriving the equations takes SymPy long, so they are kept.
        if name not in self._known:
            lines = equations_with(self.plant, name) if name in self.plant.declarations else ()
            self._known[name] = list(lines)
        return self._known[name]
