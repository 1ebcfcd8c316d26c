"""What a user may ask of the units."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from mechid.errors import UsageError
from mechid.exports.option_texts import NO, refuse_unknown, yes_or_no

STAND = "stand"


@dataclass(frozen=True, kw_only=True)
class Options:
    """What stands in the unit.

    Parameters
    ----------
    stand : bool
        The mechanism as on the bench: with housing and transducer, its base at rest. Otherwise as it flies: without the
        test stand, on a base that may turn.
    values : mapping of dotted name to float
        What differs there, in the mechanism file's units, as ``{"load.inertia": 35.0}``.
    """

    stand: bool = False
    values: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def read(cls, given: Mapping[str, str]) -> Options:
        """Return the options that texts give: ``{"stand": "yes", "load.inertia": "35"}``.

        Raises
        ------
        UsageError
            One cannot be.
        """
        values = {}
        for name, text in given.items():
            if "." not in name:
                refuse_unknown(name, [STAND], also=", and dotted names of parameters")
                continue
            try:
                values[name] = float(text)
            except ValueError:
                values[name] = math.nan
            if not math.isfinite(values[name]):
                raise UsageError(f'--option {name}: found "{text}"; write a number')
        return cls(stand=yes_or_no(STAND, given.get(STAND, NO)), values=values)
