"""Reader of quiet.toml: rates, orders, range, microsteps, converter and limits; every key has a default."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mechid.budgets.flight_entry import Flight, read_flight
from mechid.budgets.structure_entry import read_structure_entry
from mechid.campaign.place import (
    Place,
    describe_entry,
    one_of,
    positive_number,
    refuse_unknown_keys,
    texts,
)
from mechid.campaign.toml_file import read_toml
from mechid.command.entry import is_table, is_whole
from mechid.command.phase_table import MOST
from mechid.command.stepping import STEPPINGS, Stepping
from mechid.exports.linear.loops.loop_file import TABLES, loops_from_table
from mechid.quiet_drives.quantity import TORQUE, Quantity
from mechid.specification.requirement import Requirement
from mechid.specification.requirement_entry import read_requirements

FILE_NAME = "quiet.toml"
IN_CODE = Place(FILE_NAME)
"""Place of tables that come from no file, as their user would find it in one."""
KEYS = (
    "rates",
    "orders",
    "range",
    "microsteps",
    "bits",
    "steppings",
    "mean_rates",
    "seed",
    "drive",
    "limit",
    "flight",
    "axis",
    "structure",
    "requirement",
    *TABLES,
)
DRIVE_KEYS = ("peak", "pull_out_share")
LIMIT_KEYS = {"N*m": "rms_Nm", "rad": "rms_rad"}
"""Key of the limit by the unit of the quantity."""
RANGE_KEYS = ("from", "to")
LEAST_BITS, MOST_BITS = 4, 16
LEAST_MICROSTEPS, MOST_MICROSTEPS = 2, 256


@dataclass(frozen=True, kw_only=True)
class QuietDesign:
    """Content of a quiet.toml.

    Attributes
    ----------
    rates : tuple of float
        Design rates in full steps/s; empty for the middle of the range.
    orders : tuple of float
        Orders of the step rate that the table lowers most.
    ends : (float, float) or None
        Range of rates, full steps/s; None takes that of the campaign's records.
    microsteps : int or None
        Microsteps a full step; None takes that of the campaign's records, else 16.
    bits : int
        Bits of the converter, its sign included.
    steppings : tuple of Stepping
        Steppings that are compared.
    mean_rates : tuple of float
        Mean rates in full steps/s for which the best pair of rates is looked for; empty for the design rates.
    seed : int
        Of the draws.
    peak : float
        Largest magnitude of a table value, relative to the nominal peak.
    pull_out_share : float
        Least torque reserve, relative to that of the nominal table.
    rms_limit : float or None
        Largest RMS of a rate that is not forbidden, N m, or rad of a line of sight.
    quantity : Quantity
        Torque, or the line of sight through a structure.
    flight : Flight
        Values that differ in flight.
    requirements : tuple of Requirement
    """

    rates: tuple[float, ...] = ()
    orders: tuple[float, ...] = (1.0, 2.0, 4.0)
    ends: tuple[float, float] | None = None
    microsteps: int | None = None
    bits: int = 10
    steppings: tuple[Stepping, ...] = STEPPINGS
    mean_rates: tuple[float, ...] = ()
    seed: int = 0
    peak: float = 1.0
    pull_out_share: float = 0.9
    rms_limit: float | None = None
    quantity: Quantity = TORQUE
    flight: Flight = field(default_factory=Flight)
    requirements: tuple[Requirement, ...] = ()


def read_quiet_file(path: Path | str) -> QuietDesign:
    """Read a quiet.toml.

    Raises
    ------
    InputFileError
        The file is missing or wrong; the message is one line with place, value found and remedy.
    """
    path = Path(path)
    return quiet_design_of(read_toml(path), Place(path.name), path.parent)


def quiet_design_of(table: Mapping[str, Any], place: Place = IN_CODE, folder: Path = Path()) -> QuietDesign:
    """Return the design of the tables that a quiet.toml would hold; mask files are relative to `folder`.

    Raises
    ------
    InputFileError
        As for `read_quiet_file`.
    """
    refuse_unknown_keys(table, KEYS, place)
    # One file serves both: the loops are of `mechid export --to linear`, but a wrong one is told here too.
    loops_from_table(table, place)
    plain = QuietDesign()
    drive, drive_at = _table(table, "drive", DRIVE_KEYS, place)
    quantity = _quantity(table, place, folder)
    ends = _ends(table, place)
    rates = _numbers(table, "rates", place)
    for k, rate in enumerate(rates):
        if ends is not None and not ends[0] <= rate <= ends[1]:
            raise (
                place.key("rates")
                .item(k)
                .error(f"found {rate:g}, outside range {ends[0]:g} to {ends[1]:g}; widen range or leave the rate out")
            )
    return QuietDesign(
        rates=rates,
        orders=_numbers(table, "orders", place) or plain.orders,
        ends=ends,
        microsteps=_whole(table, "microsteps", place, LEAST_MICROSTEPS, MOST_MICROSTEPS),
        bits=_whole(table, "bits", place, LEAST_BITS, MOST_BITS) or plain.bits,
        steppings=_steppings(table, place),
        mean_rates=_numbers(table, "mean_rates", place),
        seed=_whole(table, "seed", place, 0, 2**32) or 0,
        peak=_peak(drive, drive_at),
        pull_out_share=_share(drive, drive_at, plain.pull_out_share),
        rms_limit=_rms_limit(table, quantity, place),
        quantity=quantity,
        flight=read_flight(table["flight"], place.key("flight")) if "flight" in table else Flight(),
        requirements=read_requirements(table, place, folder) if "requirement" in table else (),
    )


def _quantity(table: Mapping[str, Any], place: Place, folder: Path) -> Quantity:
    if "structure" not in table:
        if "axis" in table:
            raise place.key("axis").error("found without the table [structure] it belongs to; write both or none")
        return TORQUE
    structure, _ = read_structure_entry(table, place, folder)
    return Quantity(structure)


def _rms_limit(table: Mapping[str, Any], quantity: Quantity, place: Place) -> float | None:
    key = LIMIT_KEYS[quantity.unit]
    limit, at = _table(table, "limit", (key,), place)
    return positive_number(limit[key], at.key(key), quantity.unit.replace("*", " ")) if key in limit else None


def _peak(drive: Mapping[str, Any], place: Place) -> float:
    peak = positive_number(drive.get("peak", 1.0), place.key("peak"), "1")
    if peak < 1.0:
        raise place.key("peak").error(
            f"found {peak:g}, but the nominal sine already reaches 1; write 1 or more, or lower peak_voltage"
        )
    if peak > MOST:
        raise place.key("peak").error(f"found {peak:g}; a table holds fractions of the peak up to {MOST:g}")
    return peak


def _share(drive: Mapping[str, Any], place: Place, default: float) -> float:
    share = positive_number(drive.get("pull_out_share", default), place.key("pull_out_share"), "1")
    if share > 1.0:
        raise place.key("pull_out_share").error(
            f"found {share:g}, which the nominal table itself does not exceed; write a share up to 1"
        )
    return share


def _ends(table: Mapping[str, Any], place: Place) -> tuple[float, float] | None:
    if "range" not in table:
        return None
    own, at = _table(table, "range", RANGE_KEYS, place)
    for key in RANGE_KEYS:
        if key not in own:
            raise at.key(key).error("missing; write range = { from = 10.0, to = 120.0 }")
    low, high = (positive_number(own[key], at.key(key), "full steps/s") for key in RANGE_KEYS)
    if low >= high:
        raise at.error(f"found from {low:g} to {high:g}; write the lower rate first")
    return low, high


def _steppings(table: Mapping[str, Any], place: Place) -> tuple[Stepping, ...]:
    if "steppings" not in table:
        return STEPPINGS
    at = place.key("steppings")
    wanted = texts(table["steppings"], at, 'write steppings, as ["full", "micro"]')
    for k, word in enumerate(wanted):
        one_of(word, STEPPINGS, at.item(k))
    return tuple(one for one in STEPPINGS if one in wanted)


def _table(table: Mapping[str, Any], key: str, known: tuple[str, ...], place: Place) -> tuple[Mapping[str, Any], Place]:
    entry, at = table.get(key, {}), place.key(key)
    if not is_table(entry):
        raise at.error(f"{describe_entry(entry)}; write a table [{key}]")
    refuse_unknown_keys(entry, known, at)
    return entry, at


def _numbers(table: Mapping[str, Any], key: str, place: Place) -> tuple[float, ...]:
    entry, at = table.get(key, []), place.key(key)
    if not isinstance(entry, list):
        raise at.error(f"{describe_entry(entry)}; write numbers, such as [23.0, 46.0]")
    return tuple(dict.fromkeys(positive_number(value, at.item(k), "1") for k, value in enumerate(entry)))


def _whole(table: Mapping[str, Any], key: str, place: Place, least: int, most: int) -> int | None:
    if key not in table:
        return None
    if not is_whole(table[key], least, most):
        found = describe_entry(table[key])
        raise place.key(key).error(f"{found}; write a whole number from {least} to {most}")
    return int(table[key])
