"""What is asked of mechid for a record's file: that it reads the numbers that were written, however it is asked."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from fuzz.draw import Draw
from fuzz.trial import Misread

FACTORS = {"N*m": 1.0, "mN*m": 1e-3, "Nm": 1.0, "mNm": 1e-3, "kN*m": 1e3, "N*cm": 1e-2}
"""Of torque; what other units are is another test's."""
ASKED = ("table", "record", "bare", "listed")
QUANTITIES = ("torque", "current_phase_a", "output_angle", "rotor_rate", "voltage_phase_a", "force")


def asked(draw: Draw, columns: list[str], written: dict[str, Any]) -> dict[str, Any]:
    """Return what was written, with what mechid is to be asked."""
    return {
        "columns": {},
        "units": {},
        "rate": None,
        "damaged": False,
        **written,
        "asked": draw.choice(ASKED),
        "spec": _spec(draw, columns),
        "rows": [draw.randint(-3, 70), draw.randint(-3, 90)],
    }


def damaged(draw: Draw, path: Path, written: dict[str, Any], p: float = 0.12) -> dict[str, Any]:
    """Cut a file off or change bytes of it, in a share `p` of the inputs."""
    if not draw.chance(p):
        return written
    content = bytearray(path.read_bytes())
    if draw.chance(0.3):
        content = content[: draw.randint(0, len(content))]
    else:
        for _ in range(draw.choice((1, 1, 2, 5, 20))):
            if content:
                content[draw.randrange(len(content))] = draw.choice((0, 1, 0x7F, 0x80, 0xFF, draw.randrange(256)))
    path.write_bytes(content)
    return {**written, "damaged": True}


def _spec(draw: Draw, columns: list[str]) -> dict[str, Any]:
    """Return what a campaign may say of the file."""
    names = columns or ["torque"]
    channels = [
        {
            "quantity": quantity,
            "column": draw.choice(names) if draw.chance(0.85) else draw.choice((draw.text(), draw.whole())),
            "unit": draw.choice((None, None, "N*m", "mN*m", draw.text())),
            "gain": draw.choice((1.0, 1.0, -1.0, 2.5)),
        }
        for quantity in ("torque", *draw.sample(QUANTITIES[1:], draw.randrange(3)))
    ]
    conditioning: dict[str, Any] = {}
    if draw.chance(0.4):
        conditioning = {
            "time_stamps": draw.choice(("strict", "regular", "resample")),
            "max_gap_s": draw.choice((None, 0.002, 1.0, abs(draw.number()))),
            "window_s": draw.choice((None, [0.0, 0.03], sorted([draw.number(), draw.number()]))),
            "decimate": draw.choice((1, 1, 2, 7)),
            "cumulate": draw.choice(([], [], ["torque"])),
        }
    return {
        "channels": channels if draw.chance(0.7) else [],
        "sample_rate_hz": draw.choice((None, None, 1000.0, abs(draw.number()) or 1.0)),
        "conditioning": conditioning,
    }


def read(folder: Path, written: dict[str, Any]) -> None:
    """Have the file read, and compare."""
    path = folder / written["file"]
    {"table": _table, "record": _record, "bare": _bare, "listed": _listed}[written["asked"]](path, written)


def _table(path: Path, written: dict[str, Any]) -> None:
    from mechid.records.formats import open_table, wrap_read_errors

    with wrap_read_errors(path.name):
        table = open_table(path, path.name)
        for index, column in enumerate(table.columns):
            if column.fault is not None:
                continue
            values = table.read([index])[0]
            first, last = written["rows"]
            part = table.read([index], slice(max(first, 0), max(last, 0)))[0]
            _same(f"rows {first} to {last}", part, values[max(first, 0) : max(last, 0)])
            _same("blocks", np.concatenate([block[0] for block in table.blocks([index])] or [values]), values)
    if not written["damaged"]:
        _columns(table, written["columns"])


def _columns(table: Any, columns: dict[str, list[float]]) -> None:
    """Compare each column that was written."""
    for key, expected in columns.items():
        places = [index for index, column in enumerate(table.columns) if column.key == key]
        if not places and len(expected) > 1:
            raise Misread(f"column missing: {key!r}, there are {[c.key for c in table.columns]!r}")
        if len(places) == 1 and table.columns[places[0]].fault is None:
            _same("column", table.read(places)[0], np.array(expected), key)


def _record(path: Path, written: dict[str, Any]) -> None:
    """Read a record as a campaign asks for it."""
    from mechid.records import ChannelSpec, Conditioning, RecordSpec, TimeStamps, read_record

    spec, how = written["spec"], dict(written["spec"]["conditioning"])
    if how:
        how["time_stamps"] = TimeStamps(how["time_stamps"])
        how["cumulate"] = tuple(how["cumulate"])
        how["window_s"] = tuple(how["window_s"]) if how["window_s"] else None
    channels = tuple(ChannelSpec(**one) for one in spec["channels"])
    record = read_record(
        path,
        RecordSpec(
            name="r",
            path=path.name,
            sample_rate_hz=spec["sample_rate_hz"],
            channels=channels,
            conditioning=Conditioning(**how),
        ),
    )
    for channel in record.channels:
        values = channel.data[:]
        if not np.all(np.isfinite(values)):
            raise Misread(f"not finite: {channel.quantity}")
    if not (
        math.isfinite(record.sample_rate_hz) and record.sample_rate_hz > 0.0 and math.isfinite(record.time_start_s)
    ):
        raise Misread(f"no clock: {record.sample_rate_hz} Hz from {record.time_start_s} s")
    if not how and not written["damaged"]:
        _torque(record, written, channels)


def _torque(record: Any, written: dict[str, Any], channels: tuple[Any, ...]) -> None:
    """Compare the torque, where it is known which column it is and what its unit is."""
    asked_for = channels[0] if channels else None
    torque = record.channel("torque") if channels else record.channels[0]
    unit = (asked_for.unit if asked_for else None) or written["units"].get(torque.column, "N*m")
    if unit in FACTORS and torque.column in written["columns"]:
        gain = FACTORS[unit] * (asked_for.gain if asked_for else 1.0)
        _same("torque", torque.data[:] / gain, np.array(written["columns"][torque.column]), torque.column, 1e-12)
    if (
        written["rate"]
        and not written["spec"]["sample_rate_hz"]
        and not math.isclose(record.sample_rate_hz, written["rate"], rel_tol=1e-5)
    ):
        raise Misread(f"rate: {record.sample_rate_hz} Hz where {written['rate']} Hz were written")


def _bare(path: Path, written: dict[str, Any]) -> None:
    from mechid.records.undeclared import Hints, read_bare

    rate = written["spec"]["sample_rate_hz"]
    for record in read_bare(path, Hints(sample_rate_hz=rate)):
        for channel in record.channels:
            if not np.all(np.isfinite(channel.data[:])):
                raise Misread(f"not finite: {channel.quantity}")


def _listed(path: Path, written: dict[str, Any]) -> None:
    """List the file, as `mechid check FILE` does."""
    from io import StringIO

    from rich.console import Console

    from mechid.checks.data_file import file_document, file_numbers
    from mechid.ink.on_terminal import print_document

    data = file_numbers(path)
    print_document(file_document(data), Console(file=StringIO()))
    if not written["damaged"]:
        lengths = {row["column"]: row["samples"] for row in data["columns"]}
        for key, expected in written["columns"].items():
            if lengths.get(key, len(expected)) != len(expected):
                raise Misread(f"length: {key!r} of {len(expected)} samples is listed with {lengths[key]}")


def _same(what: str, found: Any, expected: Any, key: str = "", tolerance: float = 0.0) -> None:
    if found.shape != expected.shape:
        raise Misread(f"{what} length: {key!r} has {found.shape} where {expected.shape} was written")
    with np.errstate(all="ignore"):
        equal = np.isclose(found, expected, rtol=tolerance, atol=0.0, equal_nan=True) | (found == expected)
    if not np.all(equal):
        at = int(np.argmin(equal))
        raise Misread(f"{what} value: {key!r}[{at}] is {found[at]!r} where {expected[at]!r} was written")
