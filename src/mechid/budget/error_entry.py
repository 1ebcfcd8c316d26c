"""The ``[[error]]`` tables of a budget file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mechid.budget.other_errors import OtherError
from mechid.budget.summation import KINDS
from mechid.campaign.place import Place, number, one_of, refuse_unknown_keys, required, tables, text

KEYS = ("name", "kind", "axis", "size_rad", "spread_rad", "frequency_hz", "bandwidth_hz", "group")
REMEDIES = {
    "name": 'write name = "thermal distortion"',
    "kind": f"write one of {', '.join(KINDS)}",
    "size_rad": "write the bias, the standard deviation over time, or the amplitude, in rad",
}
OWN = {"random": "bandwidth_hz", "periodic": "frequency_hz"}
"""The key that a kind needs, and no other has."""


def read_errors(table: Mapping[str, Any], place: Place, axes: Sequence[str]) -> tuple[OtherError, ...]:
    """Return the errors of other sources, none where there are none; `axes` are the structure's lines of sight.

    Raises
    ------
    InputFileError
        A key is unknown or missing, or an entry wrong.
    """
    entries = tables(table.get("error", []), place.key("error"))
    return tuple(_error(entry, place.key("error").item(k), axes) for k, entry in enumerate(entries))


def _error(entry: Mapping[str, Any], place: Place, axes: Sequence[str]) -> OtherError:
    refuse_unknown_keys(entry, KEYS, place)
    for key, remedy in REMEDIES.items():
        required(entry, key, place, remedy)
    kind = one_of(entry["kind"], KINDS, place.key("kind"))
    for owner, key in OWN.items():
        if kind == owner:
            required(entry, key, place, f"a {kind} error needs it, in Hz")
        elif key in entry:
            raise place.key(key).error(f"is of a {owner} error, this one is {kind}; leave it out")
    chosen = one_of(entry["axis"], axes, place.key("axis")) if "axis" in entry else None
    hertz = {key: _not_below_zero(entry, key, place, "Hz") for key in OWN.values() if key in entry}
    for key, value in hertz.items():
        if value == 0.0:
            raise place.key(key).error("found 0; write a number above 0 in Hz")
    size = number(entry["size_rad"], place.key("size_rad"), "rad")
    if kind != "bias" and size < 0.0:
        raise place.key("size_rad").error(f"found {size:.9g}; write 0 or above")
    return OtherError(
        name=text(entry["name"], place.key("name"), REMEDIES["name"]),
        kind=kind,
        axes=np.array([chosen in (None, axis) for axis in axes]),
        size_rad=size,
        spread_rad=_not_below_zero(entry, "spread_rad", place, "rad"),
        group=text(entry["group"], place.key("group"), 'write group = "thermal"') if "group" in entry else "",
        **hertz,
    )


def _not_below_zero(entry: Mapping[str, Any], key: str, place: Place, unit: str) -> float:
    value = number(entry.get(key, 0.0), place.key(key), unit)
    if value < 0.0:
        raise place.key(key).error(f"found {value:.9g}; write 0 or above, in {unit}")
    return value
