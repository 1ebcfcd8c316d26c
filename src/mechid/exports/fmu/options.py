"""Options of the FMU export."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from mechid.exports.stand import read_stand


@dataclass(frozen=True, kw_only=True)
class Options:
    """Options of the FMU export.

    Parameters
    ----------
    stand : bool
        Export the mechanism as on the bench, with housing and transducer and a base at rest, instead of as in flight,
        without the test stand and on a base that can rotate.
    values : mapping of dotted name to float
        Changed parameter values in the units of the mechanism file, as ``{"load.inertia": 35.0}``.
    """

    stand: bool = False
    values: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def read(cls, given: Mapping[str, str]) -> Options:
        """Read options from strings, as ``{"stand": "yes", "load.inertia": "35"}``.

        Raises
        ------
        UsageError
            An option is unknown or has an invalid value.
        """
        stand, values = read_stand(given)
        return cls(stand=stand, values=values)
