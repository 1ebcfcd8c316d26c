"""Options of the export of linear models."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields

from mechid.errors import UsageError
from mechid.exports.linear.loops.loop_file import LoopDesign, read_loop_file
from mechid.exports.option_texts import read_rates, refuse_unknown, yes_or_no
from mechid.exports.stand import STAND
from mechid.exports.tables.options import MOST_RATES

NONE = "none"
"""Value of ``rates`` for an export without steady rates."""
LOOP = "loop"
"""Name of the option with the file of the loops."""
MOST_SAMPLES = 100_000


@dataclass(frozen=True, kw_only=True)
class Options:
    """Options of the linear export: held angle, step rates, draws, and changed parameter values.

    Parameters
    ----------
    start_angle_deg : float or None
        Held electrical angle in deg; None takes the start of the first record, or 0 without a campaign.
    rates : tuple of float or None
        Rates in full steps/s; None takes the range of the campaign, an empty tuple no rates.
    samples : int
        Number of plants drawn from the covariance.
    seed : int
        Seed of the draws.
    values : mapping of dotted name to float
        Changed parameter values in the units of the mechanism file, as ``{"load.inertia": 35.0}``.
    stand : bool
        Export the mechanism as on the bench, with housing, transducer and filters, instead of as in flight.
    loop : LoopDesign or None
        Loops of the drive electronics to be closed around the models, as of `read_loop_file`.

    Raises
    ------
    UsageError
        A value is invalid.
    """

    start_angle_deg: float | None = None
    rates: tuple[float, ...] | None = None
    samples: int = 20
    seed: int = 0
    values: Mapping[str, float] = field(default_factory=dict)
    stand: bool = False
    loop: LoopDesign | None = None

    def __post_init__(self) -> None:
        rates = self.rates or ()
        if not all(0.0 < rate < math.inf for rate in rates) or len(rates) > MOST_RATES:
            shown = ", ".join(f"{rate:g}" for rate in rates[:5])
            raise UsageError(f"rates: found {shown}; write full steps/s above 0, {MOST_RATES} at most, or {NONE}")
        if not 0 <= self.samples <= MOST_SAMPLES:
            raise UsageError(f"samples: found {self.samples}; write a whole number from 0 to {MOST_SAMPLES}")
        if self.seed < 0:
            raise UsageError(f"seed: found {self.seed}; write a whole number from 0 on")
        if self.start_angle_deg is not None and not math.isfinite(self.start_angle_deg):
            raise UsageError(f"start_angle_deg: found {self.start_angle_deg}; write electrical degrees")

    @classmethod
    def read(cls, given: Mapping[str, str]) -> Options:
        """Read options from strings of the command line, as ``{"samples": "50"}``.

        A name with a dot is a changed parameter.

        Raises
        ------
        UsageError
            An option is unknown, or its value is not a number.
        InputFileError
            The file of the loops is wrong.
        """
        names = [f.name for f in fields(cls) if f.name != "values"]
        # Dotted names are parameters, all others have to be options.
        for name in given:
            if "." not in name:
                refuse_unknown(name, names, also=", and dotted names of parameters")
        values = {name: _number(name, text) for name, text in given.items() if "." in name}
        own = {name: _value(name, text) for name, text in given.items() if "." not in name}
        return cls(**own, values=values)  # type: ignore[arg-type]


def _value(name: str, text: str) -> tuple[float, ...] | float | LoopDesign:
    if name == LOOP:
        return read_loop_file(text)
    if name == STAND:
        return yes_or_no(name, text)
    if name == "rates":
        return () if text == NONE else read_rates(text)
    return _number(name, text, whole=name != "start_angle_deg")


def _number(name: str, text: str, *, whole: bool = False) -> float:
    try:
        return int(text) if whole else float(text)
    except ValueError as error:
        kind = "a whole number" if whole else "a number"
        raise UsageError(f'--option {name}: found "{text}"; write {kind}') from error
