"""Reader of the damping in a table of the budget file, as a fraction of critical or in percent."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mechid.campaign.place import Place, not_below_zero, required
from mechid.structure.damping import ASKED_ABOVE, damping_key, damping_ratio


def required_damping(table: Mapping[str, Any], place: Place, remedy: str, *, asked_above: float = ASKED_ABOVE) -> float:
    """Return the damping of a table as a fraction of critical damping.

    Raises
    ------
    InputFileError
        It is missing, it is not a number from 0 up, or it may be meant in percent.
    """
    key = damping_key(table, str(place))
    at = place.key(key)
    value = not_below_zero(required(table, key, place, remedy), at, "1")
    return float(damping_ratio(value, key, str(at), asked_above=asked_above))
