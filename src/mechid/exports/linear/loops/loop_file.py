"""Reader of the loops in quiet.toml: `[current_loop]` and `[position_loop]`.

Other tables of the file belong to other readers and are ignored here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from mechid.campaign.place import (
    Place,
    describe_entry,
    non_negative_number,
    number,
    one_of,
    positive_number,
    refuse_unknown_keys,
    required_entry,
)
from mechid.campaign.toml_file import read_toml
from mechid.command.entry import is_table
from mechid.errors import did_you_mean

CURRENT, POSITION = TABLES = ("current_loop", "position_loop")
TIMING_KEYS = ("sample_s", "sample_rate_hz", "delay_s", "delay_samples")
CURRENT_KEYS = ("kp", "ki", *TIMING_KEYS, "supply_V")
POSITION_KEYS = ("sensor", "kp", "ki", "kd", "derivative_hz", *TIMING_KEYS, "notch")
NOTCH_KEYS = ("frequency_hz", "damping", "depth")
SENSORS = ("output_angle", "rotor_angle")
MOST_DELAY_SAMPLES = 50.0
"""Longest delay in samples; each sample adds a state for each phase."""


@dataclass(frozen=True, kw_only=True)
class SampledTiming:
    """Sample period and delay of a controller.

    Attributes
    ----------
    period_s : float
    delay_s : float
        Time from a sample to the instant at which its result acts.
    """

    period_s: float
    delay_s: float


@dataclass(frozen=True, kw_only=True)
class CurrentLoop:
    """Current controller of each phase, u = kp e + ki integral of e.

    Attributes
    ----------
    kp, ki : float
        V/A and V/(A s).
    timing : SampledTiming
    supply_V : float or None
        Largest magnitude of a phase's voltage.
    """

    kp: float
    ki: float
    timing: SampledTiming
    supply_V: float | None = None


@dataclass(frozen=True, kw_only=True)
class Notch:
    """Notch filter (s^2 + 2 depth damping w s + w^2)/(s^2 + 2 damping w s + w^2).

    Attributes
    ----------
    frequency_hz : float or None
        Centre; None for the drive-train mode of the model.
    damping : float
        Damping ratio of the denominator, which sets the width.
    depth : float
        Gain at the centre, from 0 to 1.
    """

    frequency_hz: float | None = None
    damping: float = 0.5
    depth: float = 0.1


@dataclass(frozen=True, kw_only=True)
class PositionLoop:
    """Position controller: quadrature current, or voltage without a current loop, from the error of an angle in rad.

    Attributes
    ----------
    sensor : {"output_angle", "rotor_angle"}
    kp, ki, kd : float
        A/rad, A/(rad s) and A s/rad; V instead of A for a voltage.
    derivative_hz : float or None
        Corner of the derivative's low-pass; None leaves it out.
    timing : SampledTiming
    notch : Notch or None
    """

    sensor: str
    kp: float
    ki: float
    kd: float
    timing: SampledTiming
    derivative_hz: float | None = None
    notch: Notch | None = None


@dataclass(frozen=True, kw_only=True)
class LoopDesign:
    """Loops of the electronics as a user gives them.

    Attributes
    ----------
    file : str
        Name of the file in messages.
    current : CurrentLoop or None
    position : PositionLoop or None
    """

    file: str = field(default="quiet.toml", compare=False)
    current: CurrentLoop | None = None
    position: PositionLoop | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the given values, SI units."""
        return {name: asdict(loop) for name, loop in zip(TABLES, (self.current, self.position), strict=True) if loop}


def read_loop_file(path: Path | str) -> LoopDesign:
    """Read the loops of a quiet.toml.

    Raises
    ------
    InputFileError
        The file is missing or wrong, or has neither loop; the message is one line with place, value found and remedy.
    """
    path = Path(path)
    table, place = read_toml(path), Place(path.name)
    if not any(name in table for name in TABLES):
        near = next((hint for key in table if (hint := did_you_mean(key, TABLES))), "")
        raise place.error(f"no loop{near or f'; write a table [{CURRENT}] or [{POSITION}] with its gains'}")
    return loops_from_table(table, place)


def loops_from_table(table: Mapping[str, Any], place: Place) -> LoopDesign:
    """Read the loops from the table of a whole quiet.toml; a file without them has an empty design.

    Raises
    ------
    InputFileError
        A loop is wrong.
    """
    current = _current(*_table(table, CURRENT, CURRENT_KEYS, place)) if CURRENT in table else None
    position = _position(*_table(table, POSITION, POSITION_KEYS, place)) if POSITION in table else None
    if current and position:
        ratio = position.timing.period_s / current.timing.period_s
        if ratio < 0.5 or abs(ratio - round(ratio)) > 1e-6 * ratio:
            raise place.key(POSITION).error(
                f"its sample period is {ratio:.9g} times that of [{CURRENT}]; write a whole multiple"
            )
    return LoopDesign(file=place.file, current=current, position=position)


def _table(table: Mapping[str, Any], key: str, known: Sequence[str], place: Place) -> tuple[Mapping[str, Any], Place]:
    entry, at = table[key], place.key(key)
    if not is_table(entry):
        raise at.error(f"{describe_entry(entry)}; write a table [{key}]")
    refuse_unknown_keys(entry, known, at)
    return entry, at


def _current(table: Mapping[str, Any], place: Place) -> CurrentLoop:
    kp = non_negative_number(required_entry(table, "kp", place, "write V/A"), place.key("kp"), "V/A")
    ki = non_negative_number(table.get("ki", 0.0), place.key("ki"), "V/(A s)")
    if kp == ki == 0.0:
        raise place.key("kp").error("found 0, and no ki; write a gain above 0")
    supply = positive_number(table["supply_V"], place.key("supply_V"), "V") if "supply_V" in table else None
    return CurrentLoop(kp=kp, ki=ki, timing=_timing(table, place), supply_V=supply)


def _position(table: Mapping[str, Any], place: Place) -> PositionLoop:
    kp = number(required_entry(table, "kp", place, "write A/rad"), place.key("kp"), "A/rad")
    ki = number(table.get("ki", 0.0), place.key("ki"), "A/(rad s)")
    kd = number(table.get("kd", 0.0), place.key("kd"), "A s/rad")
    if kp == ki == kd == 0.0:
        raise place.key("kp").error("found 0, and no ki or kd; write a gain")
    corner = "derivative_hz"
    return PositionLoop(
        sensor=one_of(table.get("sensor", SENSORS[0]), SENSORS, place.key("sensor")),
        kp=kp,
        ki=ki,
        kd=kd,
        derivative_hz=positive_number(table[corner], place.key(corner), "Hz") if corner in table else None,
        timing=(timing := _timing(table, place)),
        notch=_notch(table, timing, place) if "notch" in table else None,
    )


def _timing(table: Mapping[str, Any], place: Place) -> SampledTiming:
    if ("sample_s" in table) == ("sample_rate_hz" in table):
        found = "both of them" if "sample_s" in table else "neither"
        raise place.error(f"found {found} of sample_s and sample_rate_hz; write one")
    if "sample_s" in table:
        period_s = positive_number(table["sample_s"], place.key("sample_s"), "s")
    else:
        period_s = 1.0 / positive_number(table["sample_rate_hz"], place.key("sample_rate_hz"), "Hz")
    if "delay_s" in table and "delay_samples" in table:
        raise place.error("found delay_s and delay_samples; write one")
    key = "delay_s" if "delay_s" in table else "delay_samples"
    # Electronics that compute in one period act at the next sample.
    given = non_negative_number(table.get(key, 1.0), place.key(key), "s" if key == "delay_s" else "samples")
    delay_s = given if key == "delay_s" else given * period_s
    if delay_s > MOST_DELAY_SAMPLES * period_s:
        raise place.key(key).error(
            f"found {delay_s / period_s:.4g} samples of {period_s:g} s; write {MOST_DELAY_SAMPLES:g} at most"
        )
    return SampledTiming(period_s=period_s, delay_s=delay_s)


def _notch(table: Mapping[str, Any], timing: SampledTiming, place: Place) -> Notch:
    entry, at = _table(table, "notch", NOTCH_KEYS, place)
    key, half = "frequency_hz", 0.5 / timing.period_s
    frequency = positive_number(entry[key], at.key(key), "Hz") if key in entry else None
    if frequency is not None and frequency >= half:
        raise at.key(key).error(f"found {frequency:g}; write less than half the sample rate, {half:g} Hz")
    depth = non_negative_number(entry.get("depth", 0.1), at.key("depth"), "1")
    if not depth <= 1.0 or math.isclose(depth, 1.0):
        raise at.key("depth").error(f"found {depth:g}; write the gain at the centre, from 0 to below 1")
    return Notch(
        frequency_hz=frequency, damping=positive_number(entry.get("damping", 0.5), at.key("damping"), "1"), depth=depth
    )
