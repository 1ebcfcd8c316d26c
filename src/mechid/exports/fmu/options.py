"""Options of the FMU export."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from mechid.exports.stand import read_stand


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
        stand, values = read_stand(given)
        return cls(stand=stand, values=values)
