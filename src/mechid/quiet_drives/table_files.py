"""Files of a table for the drive electronics: CSV, C header, rates as CSV and TOML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from mechid.arrays import FloatArray
from mechid.command.phase_table import phase_table_text
from mechid.quiet_drives.table_command import phase_table

TABLE_NAME, HEADER_NAME, RATES_CSV, RATES_TOML = "table.csv", "table.h", "rates.csv", "rates.toml"
PER_LINE = 8
SUFFIXES = {"N*m": "Nm", "rad": "rad"}
"""End of a column's name by its unit."""


def table_csv(values: FloatArray) -> str:
    """Return a table, (4 n, 2), as CSV: one row per microstep, fractions of the peak."""
    return phase_table_text(phase_table(values))


def table_header(data: Mapping[str, Any]) -> str:
    """Return the C header of a table, from the numbers of `quiet_numbers`."""
    table = data["table"]
    codes, bits = table["codes"], table["bits"]
    integer = "int8_t" if bits <= 8 else "int16_t"
    lines = [
        "/* Microstep table made by mechid quiet.",
        f" * {len(codes)} microsteps in one electrical period of 4 full steps, from electrical angle 0 on.",
        " * u_A = -U cos and u_B = +U sin in the nominal table; a code c stands for",
        f" * c / {table['largest_code']} of {table['full_scale']:g} of the peak voltage or current.",
        f" * Design rates, full steps/s: {', '.join(f'{rate:g}' for rate in data['rates'])}. */",
        "#ifndef MECHID_QUIET_TABLE_H",
        "#define MECHID_QUIET_TABLE_H",
        "",
        "#include <stdint.h>",
        "",
        f"#define MECHID_TABLE_LENGTH {len(codes)}",
        f"#define MECHID_TABLE_BITS {bits}",
        "",
        *_array(integer, "mechid_table_a", [a for a, _ in codes]),
        *_array(integer, "mechid_table_b", [b for _, b in codes]),
    ]
    for driver in data["drivers"]:
        lines += _registers(driver)
    return "\n".join([*lines, "#endif", ""])


def rates_csv(data: Mapping[str, Any]) -> str:
    """Return the level over the rate of all steppings as CSV."""
    unit = SUFFIXES[data["level_unit"]]
    rows = [
        f"{curve['stepping']},{rate!r},{_cell(level)},{_cell(bound)},{verdict}"
        for curve in data["survey"]["curves"]
        for rate, level, bound, verdict in zip(
            curve["rates"], curve["level"], curve["bound"], curve["verdicts"], strict=True
        )
    ]
    return "\n".join([f"stepping,rate,rms_{unit},bound_{unit},verdict", *rows]) + "\n"


def rates_toml(data: Mapping[str, Any]) -> str:
    """Return recommended and forbidden bands and the pairs of rates as TOML."""
    unit = SUFFIXES[data["level_unit"]]
    lines = ["# Bands of rates in full steps/s, made by mechid quiet."]
    for band in data["survey"]["bands"]:
        lines += [
            "",
            "[[band]]",
            f'stepping = "{band["stepping"]}"',
            f'verdict = "{band["verdict"]}"',
            f"from = {band['low']!r}",
            f"to = {band['high']!r}",
        ]
        if band["worst"] is not None:
            lines.append(f"worst_{unit} = {band['worst']!r}")
    for pair in data["survey"]["pairs"]:
        lines += ["", "[[pair]]", f'stepping = "{pair["stepping"]}"']
        lines += [f"{key} = {pair[key]!r}" for key in ("mean", "low", "high", "share")]
        lines.append(f"rms_{unit} = {pair['rms']!r}")
    return "\n".join(lines) + "\n"


def _cell(value: float | None) -> str:
    return "" if value is None else repr(value)


def _array(integer: str, name: str, codes: Sequence[int]) -> list[str]:
    rows = [codes[k : k + PER_LINE] for k in range(0, len(codes), PER_LINE)]
    own = [f"    {', '.join(f'{code:d}' for code in row)}," for row in rows]
    return [f"static const {integer} {name}[MECHID_TABLE_LENGTH] = {{", *own, "};", ""]


def _registers(driver: Mapping[str, Any]) -> list[str]:
    if not driver["registers"]:
        return []
    prefix = "".join(c if c.isalnum() else "_" for c in driver["driver"].upper())
    own = [f"#define {prefix}_{name} 0x{value:08X}u" for name, value in driver["registers"].items()]
    return [f"/* {driver['driver']}: {driver['note']} */", *own, ""]
