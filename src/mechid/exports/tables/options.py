"""Options of the export of tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

from mechid.errors import UsageError
from mechid.exports.option_texts import read_rates, refuse_unknown, yes_or_no
from mechid.exports.stand import STAND
from mechid.exports.stepping import FASTEST, SLOWEST

MOST_RATES = 2000
# Nastran's identifiers have eight digits, and a file numbers its loads consecutively from the first one.
LARGEST_ID = 99_000_000
"""Largest first identifier of load sets and tables."""


@dataclass(frozen=True, kw_only=True)
class Options:
    """Options of the table export: rates, and location and scale of the Nastran loads.

    Parameters
    ----------
    rates : tuple of float
        Rates in full steps/s; an empty tuple takes the range of the campaign.
    node : int
        Grid point of the mechanism.
    component : int
        Degree of freedom of the mechanism's axis, 4 to 6: rotation about x, y or z.
    scale : float
        Torque units of the structural model in 1 N m; 1000 for N mm.
    first_id : int
        First identifier of load sets and tables, which are numbered consecutively.
    stand : bool
        Tabulate the torque at the transducer, for the mechanism as on the bench, instead of the torque on the base in
        flight.

    Raises
    ------
    UsageError
        A value is invalid.
    """

    rates: tuple[float, ...] = ()
    node: int = 1
    component: int = 6
    scale: float = 1.0
    first_id: int = 900_001
    stand: bool = False

    def __post_init__(self) -> None:
        wrong = [rate for rate in self.rates if not SLOWEST <= rate <= FASTEST]
        if wrong or len(self.rates) > MOST_RATES:
            found = f"{wrong[0]:g}" if wrong else f"{len(self.rates)} of them"
            raise UsageError(
                f"rates: found {found}; write full steps/s from {SLOWEST:g} to {FASTEST:g}, {MOST_RATES} at most"
            )
        for name, least, most in (("node", 1, LARGEST_ID), ("component", 4, 6), ("first_id", 1, LARGEST_ID)):
            if not least <= getattr(self, name) <= most:
                raise UsageError(f"{name}: found {getattr(self, name)}; write a whole number from {least} to {most}")
        if not 0.0 < abs(self.scale) < float("inf"):
            raise UsageError(f"scale: found {self.scale:g}; write the model's torque units in 1 N m, as 1000 for N mm")

    @classmethod
    def read(cls, given: Mapping[str, str]) -> Options:
        """Read options from strings of the command line, as ``{"rates": "23,46"}``.

        Raises
        ------
        UsageError
            An option is unknown, or its value is not a number.
        """
        names = [field.name for field in fields(cls)]
        for name in given:
            refuse_unknown(name, names)
        return cls(**{name: _value(name, text) for name, text in given.items()})  # type: ignore[arg-type]


def _value(name: str, text: str) -> tuple[float, ...] | float | int:
    if name == STAND:
        return yes_or_no(name, text)
    if name == "rates":
        return read_rates(text)
    try:
        return float(text) if name == "scale" else int(text)
    except ValueError as error:
        kind = "a number" if name == "scale" else "a whole number"
        raise UsageError(f'--option {name}: found "{text}"; write {kind}') from error
