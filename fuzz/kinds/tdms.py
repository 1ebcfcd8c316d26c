"""TDMS files: objects, properties, types of numbers, several segments, and heads with fields changed."""

import struct
from pathlib import Path
from typing import Any

import numpy as np

from fuzz.draw import Draw
from fuzz.kinds.arrays import UNITS, expected, length, values
from fuzz.kinds.records_read import asked, damaged

TYPES = ("f8", "f8", "f8", "f4", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "?", "c16", "M8[us]")


def write_tdms(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write groups of channels, each with its clock."""
    from nptdms import TdmsWriter

    path, count = folder / "run.tdms", length(draw)
    same, own = {**_clock(draw, 1000.0)}, draw.chance(0.3)
    channels, columns, units = [], {}, {}
    segments = draw.choice((1, 1, 1, 2, 3))
    for k in range(draw.randint(1, 3)):
        group = draw.choice(("run", "run", "run", draw.text() or "g")).replace("\0", "")
        name = draw.choice((f"Mz{k}", f"Mz{k}", draw.text() or "c")).replace("\0", "")
        unit = draw.choice(UNITS) if draw.chance(0.4) else None
        properties = {**(_clock(draw, draw.choice((1000.0, 46.0))) if own else same), **_properties(draw)}
        if unit:
            properties["unit_string"] = unit
        kind = draw.choice(TYPES) if draw.chance(0.25) else "f8"
        size = count if draw.chance(0.9) else length(draw)
        parts = [values(draw, size, kind) for _ in range(segments)]
        if draw.chance(0.1):
            properties |= _scaling(draw)
        elif "/" not in group + name:
            columns |= expected(f"{group}/{name}", np.concatenate(parts))
            units[f"{group}/{name}"] = unit or "N*m"
        channels.append((group, name, parts, properties))
    with TdmsWriter(path, version=draw.choice((4712, 4713))) as file:
        for segment in range(segments):
            file.write_segment(_objects(draw, channels, segment))
    twice = {(group, name) for group, name, *_ in channels}
    if draw.chance(0.2):
        _change_fields(draw, path)
        return asked(draw, list(units), {"file": path.name, "damaged": True})
    known = columns if len(twice) == len(channels) else {}
    return damaged(draw, path, asked(draw, list(units), {"file": path.name, "columns": known, "units": units}))


def _objects(draw: Draw, channels: list[Any], segment: int) -> list[Any]:
    from nptdms import ChannelObject, GroupObject, RootObject

    own = [ChannelObject(group, name, parts[segment], properties) for group, name, parts, properties in channels]
    if segment or draw.chance(0.3):
        return own
    return [RootObject(_properties(draw)), GroupObject("run", _properties(draw)), *own]


def _clock(draw: Draw, rate: float) -> dict[str, Any]:
    """Return the properties of a clock, at times odd ones."""
    if draw.chance(0.15):
        return {}
    increment = 1.0 / rate if draw.chance(0.8) else draw.choice((draw.number(), "fast", 0.0, -0.001))
    found: dict[str, Any] = {"wf_increment": increment}
    if draw.chance(0.7):
        found["wf_start_offset"] = 0.0 if draw.chance(0.8) else draw.choice((draw.number(), "x"))
    if draw.chance(0.5):
        found["wf_start_time"] = np.datetime64("2024-05-06T07:08:09") if draw.chance(0.8) else draw.choice(("now", 5.0))
    if draw.chance(0.3):
        found["wf_samples"] = draw.choice((64, 0, 1, -1))
    return found


def _properties(draw: Draw) -> dict[str, Any]:
    return {
        (draw.text() or "p").replace("\0", ""): draw.choice(
            (draw.text().replace("\0", ""), draw.number(), draw.randint(-5, 2**31 - 1), True)
        )
        for _ in range(draw.choice((0, 0, 1, 3)))
    }


def _scaling(draw: Draw) -> dict[str, Any]:
    """Return a scaling, which npTDMS applies, or one that it does not know."""
    kind = draw.choice(("Linear", "Polynomial", "Table", "Thermocouple", "Unknown", "RTD"))
    number = draw.choice((1, 1, 2, 0, -1))
    return {
        "NI_Number_Of_Scales": number,
        "NI_Scale[0]_Scale_Type": kind,
        "NI_Scale[0]_Linear_Slope": draw.number(),
        "NI_Scale[0]_Linear_Y_Intercept": draw.choice((0.0, draw.number())),
        "NI_Scale[0]_Linear_Input_Source": draw.choice((0xFFFFFFFF, 0, 5)),
        "NI_Scaling_Status": draw.choice(("unscaled", "scaled", "")),
    }


def _change_fields(draw: Draw, path: Path) -> None:
    """Change lead-in and index: masks, versions, offsets, counts and types."""
    content = bytearray(path.read_bytes())
    for _ in range(draw.randint(1, 3)):
        at = draw.choice((4, 8, 12, 16, 20, 24, 28, draw.randrange(28, max(len(content) - 8, 29))))
        value = draw.choice((0, 1, 2, 10, 0x0E, 0x20, 0x19, 0x44, 0xFFFFFFFF, 0x7FFFFFFF, draw.randrange(256)))
        content[at : at + 4] = struct.pack("<I", value)
    path.write_bytes(content)
