"""A found table in the layouts of drivers with a programmable wave, with the gain that each keeps."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.plant.mechanism import Mechanism
from mechid.quiet_drives.driver_registers import (
    AMPLITUDE,
    DRV,
    DRV_FIRST_REGISTER,
    DRV_LARGEST,
    DRV_MICROSTEPS,
    QUARTER,
    TMC,
    eighth_step_codes,
    encode_quarter,
    quarter_of_table,
    table_of_quarter,
)
from mechid.quiet_drives.improvement import unit_gains
from mechid.quiet_drives.settings import QUIET
from mechid.quiet_drives.table_basis import quarter_wave_harmonics
from mechid.quiet_drives.table_cost import TableCost
from mechid.quiet_drives.table_search import search_table

DIRECT = "TMC2130/TMC5130 direct mode"
DIRECT_LARGEST = 255


@dataclass(frozen=True, eq=False)
class DriverLayout:
    """A table as a driver holds it.

    Attributes
    ----------
    driver : str
    registers : mapping of str to int
        Empty if the driver has none for it.
    gains_db : mapping of float to float
        By design rate the gain that is left, dB; empty if the driver cannot hold the table.
    note : str
    """

    driver: str
    registers: Mapping[str, int]
    gains_db: Mapping[float, float]
    note: str


def driver_layouts(
    mechanism: Mechanism, cost: TableCost, table: FloatArray, rates: Sequence[float], say: Callable[[str], None]
) -> tuple[DriverLayout, ...]:
    """Return a table, (4 n, 2), in each layout; tables of one quarter wave are searched for anew."""
    microsteps = len(table) // 4
    direct = np.clip(np.rint(table * DIRECT_LARGEST), -DIRECT_LARGEST, DIRECT_LARGEST) / DIRECT_LARGEST
    out = [
        DriverLayout(
            DIRECT,
            {},
            _gains(mechanism, cost, direct, rates),
            "XDIRECT (0x2D), signed 9-bit codes of both coils written at each microstep: 255 times table.csv",
        )
    ]
    say("table of one quarter wave for drivers that hold no other")
    quarter = search_table(cost, quarter_wave_harmonics(microsteps, QUIET.highest_harmonic), (), say).table
    if QUARTER % microsteps == 0:
        encoded = encode_quarter(quarter_of_table(quarter))
        played = table_of_quarter(encoded.wave / AMPLITUDE, microsteps)
        note = "coil A drives phase B, coil B drives phase A with reversed sign; amplitude 247 of 255"
        out.append(DriverLayout(TMC, encoded.registers, _gains(mechanism, cost, played, rates), note))
    if microsteps == DRV_MICROSTEPS:
        codes = eighth_step_codes(quarter)
        wave = np.interp(np.arange(QUARTER + 1) / (QUARTER / DRV_MICROSTEPS), np.arange(9), [0, *codes]) / DRV_LARGEST
        names = {f"CUSTOM_CURRENT{k + 1}_AT_{DRV_FIRST_REGISTER + k:02X}": code for k, code in enumerate(codes)}
        gains = _gains(mechanism, cost, table_of_quarter(wave, microsteps), rates)
        out.append(DriverLayout(DRV, names, gains, "EN_CUSTOM = 1; registers 0x17 to 0x1E"))
    else:
        out.append(DriverLayout(DRV, {}, {}, "holds tables of 8 microsteps a full step only: set microsteps = 8"))
    return tuple(out)


def _gains(mechanism: Mechanism, cost: TableCost, table: FloatArray, rates: Sequence[float]) -> dict[float, float]:
    return {one.rate: one.gain_db for one in unit_gains(mechanism, cost.base, table, rates, cost.quantity)}
