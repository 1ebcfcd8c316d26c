"""Reader of the ``[[requirement]]`` tables of a budget file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from mechid.budgets.indices import KINDS, Index
from mechid.budgets.levels import CONE, INTERPRETATIONS
from mechid.budgets.requirement import Requirement
from mechid.campaign.place import (
    Place,
    number,
    one_of,
    positive_number,
    refuse_unknown_keys,
    required_entry,
    tables,
    text,
)
from mechid.errors import InputFileError
from mechid.specification.requirement_entry import is_on_emission

KEYS = (
    "name",
    "index",
    "window_s",
    "separation_s",
    "axis",
    "limit_rad",
    "interpretation",
    "confidence",
    "evaluation_period_s",
)
REMEDIES = {
    "name": 'write name = "stability over an exposure"',
    "index": f"write one of {', '.join(KINDS)}",
    "axis": "write a line of sight of the structure, or cone",
    "limit_rad": "write the limit in rad, such as 1e-6",
    "interpretation": f"write one of {', '.join(INTERPRETATIONS)}",
    "confidence": "write the share, such as 0.9973",
    "evaluation_period_s": "write the time in s over which the error is evaluated",
}


def read_requirements(table: Mapping[str, Any], place: Place, axes: Sequence[str]) -> tuple[Requirement, ...]:
    """Return the requirements on the line of sight, empty if there are none; `axes` are the structure's.

    Those on the emission at the interface, which have a `kind` or a mask, are passed over.

    Raises
    ------
    InputFileError
        A key is unknown or missing, or an entry wrong.
    """
    return tuple(
        _requirement(entry, at, axes) for entry, at in tables(table, "requirement", place) if not is_on_emission(entry)
    )


def _requirement(entry: Mapping[str, Any], place: Place, axes: Sequence[str]) -> Requirement:
    refuse_unknown_keys(entry, KEYS, place)
    for key, remedy in REMEDIES.items():
        required_entry(entry, key, place, remedy)
    period = positive_number(entry["evaluation_period_s"], place.key("evaluation_period_s"), "s")
    index = _index(entry, place)
    if index.row.one_period and index.longest_s > period:
        raise place.key("evaluation_period_s").error(f"found {period:.9g}; the windows take {index.longest_s:.9g} s")
    confidence = number(entry["confidence"], place.key("confidence"), "1")
    if not 0.0 < confidence < 1.0:
        raise place.key("confidence").error(f"found {confidence:.9g}; write a share between 0 and 1, such as 0.9973")
    return Requirement(
        name=text(entry["name"], place.key("name"), REMEDIES["name"]),
        index=index,
        axis=one_of(entry["axis"], (*axes, CONE), place.key("axis")),
        limit_rad=positive_number(entry["limit_rad"], place.key("limit_rad"), "rad"),
        interpretation=one_of(entry["interpretation"], INTERPRETATIONS, place.key("interpretation")),
        confidence=confidence,
        evaluation_period_s=period,
    )


def _index(entry: Mapping[str, Any], place: Place) -> Index:
    kind = one_of(entry["index"], tuple(KINDS), place.key("index"))
    times = [number(entry.get(key, 0.0), place.key(key), "s") for key in ("window_s", "separation_s")]
    try:
        return Index(kind, *times)
    except InputFileError as error:
        raise InputFileError(f"{place}.{error}") from error
