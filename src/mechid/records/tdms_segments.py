"""Properties of TDMS channels by segment.

Each segment of a TDMS file may redefine the properties of its channels. npTDMS merges them, so that the last value
applies to all samples. This is correct for a correction that is appended without samples, but wrong if samples with a
different unit, rate, scaling or start follow.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, BinaryIO

import numpy as np

from mechid.errors import RecordError
from mechid.records.scaling import is_scaling_name
from mechid.records.settings import STAMPS
from mechid.records.third_party import import_library
from mechid.units import SI_UNIT, to_si_factor

ROOT = "/"
UNIT, INCREMENT, START, OFFSET = "unit_string", "wf_increment", "wf_start_time", "wf_start_offset"
SCALING = re.compile(r"NI_(Scal|Number_Of_Scales)")
"""Beginning of the names of properties that define the scaling of raw numbers."""
REMEDY = "save each part as a file of its own"

Properties = Mapping[str, Any]


@dataclass(frozen=True)
class Part:
    """Consecutive samples of a channel that share their properties.

    Attributes
    ----------
    first : int
        Number of the channel's samples before the part.
    properties : Mapping
        Unit, clock and scaling that apply to these samples.
    """

    first: int
    properties: Properties


def read_parts(file: BinaryIO, label: str) -> Mapping[str, Sequence[Part]]:
    """Return the parts of each channel of an open TDMS file, by the channel's path; samples are not read.

    Raises
    ------
    RecordError
        The installed version of npTDMS does not expose the properties of each segment.
    """
    nptdms = import_library("nptdms.reader", "npTDMS", label)
    object_path = import_library("nptdms.common", "npTDMS", label).ObjectPath

    class Reader(nptdms.TdmsReader):  # type: ignore[name-defined]
        """Reader that records the properties after each segment, before the next one replaces them."""

        def __init__(self) -> None:
            super().__init__(file)
            self.segments_seen = 0
            self.parts: dict[str, list[Part]] = {}
            self.counted: dict[str, int] = {}

        def _update_object_properties(self, stated: Any) -> None:
            super()._update_object_properties(stated)
            self.segments_seen += 1
            for path, found in self.object_metadata.items():
                before = self.counted.get(path, 0)
                if found.num_values > before:
                    self.counted[path] = found.num_values
                    if stated or before == 0:
                        self._add(path, before)

        def _add(self, path: str, before: int) -> None:
            # Each may state a scaling.
            levels = (ROOT, object_path.from_string(path).group_path(), path)
            stated = (self.object_metadata[level].properties for level in levels if level in self.object_metadata)
            properties = {
                key: _to_numpy(value) for level in stated for key, value in level.items() if _is_relevant(key)
            }
            parts = self.parts.setdefault(path, [])
            if not parts or parts[-1].properties != properties:
                parts.append(Part(before, properties))

    reader = Reader()
    reader.read_metadata()
    # Both are private to npTDMS and may change with its version.
    if reader.segments_seen != len(reader._segments):
        raise RecordError(f"{label}: this version of npTDMS does not show the properties of each segment; install 1.13")
    return reader.parts


def first_start(parts: Sequence[Part], properties: Properties) -> Properties:
    """Return a channel's properties with the start of its first part, unless a correction follows the last part."""
    starts = [{key: part.properties[key] for key in (START, OFFSET) if key in part.properties} for part in parts]
    is_corrected = not starts or any(properties.get(key) != starts[-1].get(key) for key in (START, OFFSET))
    return properties if is_corrected else {**properties, **starts[0]}


def parts_fault(parts: Sequence[Part]) -> str | None:
    """Return the reason why the parts of a channel do not form one series, with both values, or None."""
    for before, after in pairwise(parts):
        one, other = before.properties, after.properties
        for key in sorted(one.keys() | other.keys()):
            if key in (START, OFFSET) or _is_same(key, one.get(key), other.get(key)):
                continue
            shown = [_format_value(properties.get(key)) for properties in (one, other)]
            return (
                f"its segments differ: {key} is {shown[0]} before sample {after.first} and {shown[1]} from there on; "
                f"{REMEDY}"
            )
        fault = _start_fault(before, after)
        if fault:
            return fault
    return None


def _start_fault(before: Part, after: Part) -> str | None:
    """Return the reason why a part does not directly follow its predecessor, or None; a repeated start is ignored."""
    one, other = (_start(part.properties) for part in (before, after))
    interval = float(before.properties.get(INCREMENT, 0.0))
    if one == other or interval <= 0.0 or (one[0] is None) != (other[0] is None):
        return None
    elapsed = other[1] - one[1]
    if one[0] is not None and other[0] is not None:
        elapsed += float((other[0] - one[0]) / np.timedelta64(1, "us")) * 1e-6
    expected = (after.first - before.first) * interval
    if abs(elapsed - expected) <= interval + STAMPS.stamp_s:
        return None
    return (
        f"its segments do not follow each other: from sample {before.first} to sample {after.first} it is "
        f"{expected:.9g} s by {INCREMENT} and {elapsed:.9g} s by {START} and {OFFSET} ({_start_words(*one)}; "
        f"{_start_words(*other)}); {REMEDY}"
    )


def _start(properties: Properties) -> tuple[np.datetime64 | None, float]:
    start = properties.get(START)
    return start if isinstance(start, np.datetime64) else None, float(properties.get(OFFSET, 0.0))


def _is_relevant(key: str) -> bool:
    return key in (UNIT, INCREMENT, START, OFFSET) or SCALING.match(key) is not None or is_scaling_name(key)


def _to_numpy(value: Any) -> Any:
    """Return a property's value, with time stamps converted to NumPy's type."""
    return value.as_datetime64("us") if hasattr(value, "as_datetime64") else value


def _is_same(key: str, one: Any, other: Any) -> bool:
    if one is None or other is None:
        return one is other
    if key == INCREMENT:
        return bool(abs(float(other) - float(one)) <= STAMPS.same_increment * abs(float(one)))
    return bool(one == other) or (key == UNIT and _factors(str(one)) == _factors(str(other)) != {})


def _factors(unit: str) -> dict[str, float]:
    """Return the factor to SI for each quantity that a unit measures."""
    found = {}
    for quantity in SI_UNIT:
        with suppress(RecordError):
            found[quantity] = to_si_factor(unit, quantity)
    return found


def _format_value(value: Any) -> str:
    if value is None:
        return "not stated"
    text = " ".join(str(value).split())
    return f'"{text}"' if isinstance(value, str) else text


def _start_words(start: np.datetime64 | None, offset: float) -> str:
    return f"{'no date' if start is None else start} and {offset:.9g} s"
