"""Terms that a fit has beside the mechanism as written: their values, as estimate.json keeps them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Self

CLEAR = 3.0
"""Standard errors from nothing beyond which a term is clear; a choice, not measured."""


@dataclass(frozen=True, kw_only=True)
class TermBeside:
    """A parameter of a term.

    Attributes
    ----------
    value : float
    std_error : float or None
        None where it has none.
    unit : str
    width : float or None
        Standard deviation of its small prior, None where there is none.
    term : str
        The term that it is of.
    meaning : str
        What the parameter is, in words.
    """

    value: float
    std_error: float | None
    unit: str
    width: float | None
    term: str
    meaning: str


@dataclass(frozen=True, kw_only=True)
class TermsBeside:
    """The terms.

    Attributes
    ----------
    names : tuple of str
        As diagnosis calls them, e.g. ``"stepper.detent:0.9deg"``.
    words : mapping of str to str
        What each of them is, by its name.
    parameters : mapping of str to TermBeside
        By dotted name, as they would stand in the mechanism file behind what it has.
    """

    names: tuple[str, ...]
    words: Mapping[str, str]
    parameters: Mapping[str, TermBeside]

    @property
    def clear(self) -> tuple[str, ...]:
        """Names of the terms of which a parameter is at least `CLEAR` standard errors from nothing, the clearest first.

        A phase says nothing of that.
        """
        sizes = [
            (abs(p.value) / p.std_error, p.term) for p in self.parameters.values() if p.std_error and p.unit != "deg"
        ]
        return tuple(dict.fromkeys(term for size, term in sorted(sizes, reverse=True) if size >= CLEAR))

    def to_dict(self) -> dict[str, object]:
        """Return the entry of estimate.json."""
        parameters = {name: asdict(p) for name, p in self.parameters.items()}
        return {"names": list(self.names), "words": dict(self.words), "parameters": parameters}

    @classmethod
    def from_dict(cls, entry: Mapping[str, Any]) -> Self:
        """Return what an entry of estimate.json says."""
        parameters = {name: TermBeside(**p) for name, p in entry["parameters"].items()}
        return cls(names=tuple(entry["names"]), words=dict(entry["words"]), parameters=parameters)
