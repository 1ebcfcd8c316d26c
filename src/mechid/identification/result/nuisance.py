"""Nuisance parameters of a held-out record, fitted on its first part with the mechanism held: time offset, gain, ..."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Self

from mechid.identification.result.missing import OwnValue


@dataclass(frozen=True, kw_only=True)
class Nuisance:
    """Parameters of one held-out record that were fitted on its first part; it is judged by the rest.

    Attributes
    ----------
    samples : int
        Of the first part.
    until_s : float
        Record time at which that ends, and from which on the record is judged.
    parameters : mapping of dotted name to OwnValue
        Values, in the file's units, with their standard errors; no error where the first part does not tell one.
    """

    samples: int
    until_s: float
    parameters: Mapping[str, OwnValue]

    @property
    def values(self) -> dict[str, float]:
        """The values by dotted name."""
        return {name: own.value for name, own in self.parameters.items()}

    def words(self) -> Iterator[str]:
        """Yield each value with its error, named as the record's table names it."""
        for name, own in self.parameters.items():
            error = "" if own.std_error is None else f" +- {own.std_error:.2g}"
            yield f"{name.split('.', 2)[2]} = {own.value:.6g}{error} {own.unit}".rstrip()

    def to_dict(self) -> dict[str, Any]:
        """Return what estimate.json says of it."""
        return {
            "samples": self.samples,
            "until_s": self.until_s,
            "parameters": {name: asdict(own) for name, own in self.parameters.items()},
        }

    @classmethod
    def from_dict(cls, entry: Mapping[str, Any]) -> Self:
        """Return what `to_dict` wrote down."""
        own = {name: OwnValue(**value) for name, value in entry["parameters"].items()}
        return cls(samples=int(entry["samples"]), until_s=float(entry["until_s"]), parameters=own)
