"""Terms that a fit has beside the mechanism as written: their values, as estimate.json keeps them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Self


@dataclass(frozen=True, kw_only=True)
class TermBeside:
    """A parameter of a term: value, standard error (None where it has none) and unit; width of its small prior."""

    value: float
    std_error: float | None
    unit: str
    width: float | None


@dataclass(frozen=True, kw_only=True)
class TermsBeside:
    """The terms.

    Attributes
    ----------
    names : tuple of str
        As diagnosis calls them, e.g. ``"stepper.detent:0.9deg"``.
    parameters : mapping of str to TermBeside
        By dotted name, as they would stand in the mechanism file behind what it has.
    """

    names: tuple[str, ...]
    parameters: Mapping[str, TermBeside]

    def largest(self, least: float) -> list[str]:
        """Return the dotted names of what is at least so many standard errors from nothing, the clearest first."""
        clear = {n: abs(p.value) / p.std_error for n, p in self.parameters.items() if p.std_error and p.unit != "deg"}
        return sorted((n for n in clear if clear[n] >= least), key=lambda n: -clear[n])

    def to_dict(self) -> dict[str, object]:
        """Return the entry of estimate.json."""
        return {"names": list(self.names), "parameters": {name: asdict(p) for name, p in self.parameters.items()}}

    @classmethod
    def from_dict(cls, entry: Mapping[str, Any]) -> Self:
        """Return what an entry of estimate.json says."""
        parameters = {name: TermBeside(**p) for name, p in entry["parameters"].items()}
        return cls(names=tuple(entry["names"]), parameters=parameters)
