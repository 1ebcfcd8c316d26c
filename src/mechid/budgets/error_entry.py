"""Reader of the ``[[error]]`` tables of a budget file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mechid.budgets.other_errors import OtherError
from mechid.budgets.summation import KINDS
from mechid.campaign.place import (
    Place,
    above_zero,
    not_below_zero,
    number,
    one_of,
    refuse_unknown_keys,
    required,
    tables,
    text,
)

KEYS = ("name", "kind", "axis", "size_rad", "spread_rad", "frequency_hz", "bandwidth_hz", "group")
REMEDIES = {
    "name": 'write name = "thermal distortion"',
    "kind": f"write one of {', '.join(KINDS)}",
    "size_rad": "write the bias, the standard deviation over time, or the amplitude, in rad",
}
OWN = {"random": "bandwidth_hz", "periodic": "frequency_hz"}
"""Key that one kind requires and the others refuse."""


def read_errors(table: Mapping[str, Any], place: Place, axes: Sequence[str]) -> tuple[OtherError, ...]:
    """Return the errors of other sources, empty if there are none; `axes` are the structure's lines of sight.

    Raises
    ------
    InputFileError
        A key is unknown or missing, or an entry is wrong.
    """
    return tuple(_error(entry, at, axes) for entry, at in tables(table, "error", place))


def _error(entry: Mapping[str, Any], place: Place, axes: Sequence[str]) -> OtherError:
    refuse_unknown_keys(entry, KEYS, place)
    for key, remedy in REMEDIES.items():
        required(entry, key, place, remedy)
    kind = one_of(entry["kind"], KINDS, place.key("kind"))
    for owner, key in OWN.items():
        if kind == owner:
            required(entry, key, place, f"a {kind} error needs it, in Hz")
        elif key in entry:
            raise place.key(key).error(f"belongs to a {owner} error; this one is {kind}; leave it out")
    chosen = one_of(entry["axis"], axes, place.key("axis")) if "axis" in entry else None
    hertz = {key: above_zero(entry[key], place.key(key), "Hz") for key in OWN.values() if key in entry}
    # A bias has a sign; a standard deviation and an amplitude have none.
    checked = number if kind == "bias" else not_below_zero
    return OtherError(
        name=text(entry["name"], place.key("name"), REMEDIES["name"]),
        kind=kind,
        axes=np.array([chosen in (None, axis) for axis in axes]),
        size_rad=checked(entry["size_rad"], place.key("size_rad"), "rad"),
        spread_rad=not_below_zero(entry.get("spread_rad", 0.0), place.key("spread_rad"), "rad"),
        group=text(entry["group"], place.key("group"), 'write group = "thermal"') if "group" in entry else "",
        **hertz,
    )
