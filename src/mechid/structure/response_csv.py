"""Reader of frequency responses in CSV format: ``frequency_Hz``, then a pair of columns per complex response.

A pair is ``<name>_re`` and ``<name>_im``, or ``<name>_mag`` and ``<name>_phase_deg``, ``<name>_phase_rad`` or
``<name>_phase [deg]``, for the interface and each line of sight. The unit in brackets distinguishes receptance,
mobility and accelerance; the default is rad/(N*m). If the budget names `directions`, each line of sight also has a pair
for each of them, ``<line of sight>_<name>_re`` and so on, in rad/N for a force.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.errors import InputFileError, did_you_mean
from mechid.structure.checks import LARGEST_RECEPTANCE, refuse_overflow, response_findings
from mechid.structure.csv_table import read_numbers, split_unit
from mechid.structure.frequency import FREQUENCY, as_hertz
from mechid.structure.polar import LINEAR, from_polar, is_decibel, phase_in_radians, refuse_hidden_levels, refuse_levels
from mechid.structure.response import KINDS, FrequencyResponse, to_receptance
from mechid.structure.selection import ROTATIONS, Selection
from mechid.structure.structure import Structure
from mechid.units import conversion_factor

INTERFACE = "interface"
PAIRS = (("_re", "_im"), *(("_mag", phase) for phase in ("_phase_deg", "_phase_rad", "_phase")))
Column = tuple[FloatArray, str | None]


def read_response_csv(path: Path, selection: Selection) -> Structure:
    """Read a frequency response and check its passivity, causality and resolution.

    Raises
    ------
    InputFileError
        A column or its partner is missing, its unit has the wrong dimension, or its numbers are invalid.
    """
    frequency_hz, columns = read_columns(path)
    # A column that ends in a direction's name belongs to that direction, and is no line of sight of its own.
    names, own = response_names(columns, path.name), dict.fromkeys(selection.directions.values())
    sights = [name for name in names if name != INTERFACE and not any(name.endswith(f"_{one}") for one in own)]
    found = {n: _complex_response(n, columns, frequency_hz, path.name) for n in names if n in sights or n == INTERFACE}
    structure = structure_of_responses(path.name, frequency_hz, found)
    along = {}
    for direction, name in selection.directions.items():
        for sight in sights:
            if f"{sight}_{name}" not in names:
                columns_of = f'"{sight}_{name}_re" and "{sight}_{name}_im"'
                raise InputFileError(f"{path.name}: directions: {direction}: no columns {columns_of}")
        pairs = [
            _complex_response(f"{sight}_{name}", columns, frequency_hz, path.name, load_unit(direction))
            for sight in sights
        ]
        along[direction] = response_to_direction(frequency_hz, pairs)
    return add_directions(structure, along)


def read_columns(path: Path) -> tuple[FloatArray, dict[str, Column]]:
    """Return the frequencies in Hz, (n,), and the other columns by name, each with its unit.

    Raises
    ------
    InputFileError
        The frequencies are missing, or two columns have one name.
    """
    columns: dict[str, Column] = {}
    for header, data in read_numbers(path).items():
        name, unit = split_unit(header)
        hertz = as_hertz(name, unit, data, path.name)
        name, column = (name, (data, unit)) if hertz is None else (FREQUENCY, (hertz, "Hz"))
        if name in columns:
            raise InputFileError(f'{path.name}: column "{header}": holds {name}, as does another column; remove one')
        columns[name] = column
    if FREQUENCY not in columns:
        raise InputFileError(f'{path.name}: no column "{FREQUENCY}"{did_you_mean(FREQUENCY, columns)}')
    return columns.pop(FREQUENCY)[0], columns


def load_unit(direction: str) -> str:
    """Return the unit of the torque or force along a direction."""
    return "N*m" if direction in ROTATIONS else "N"


def add_directions(structure: Structure, along: Mapping[str, FrequencyResponse]) -> Structure:
    """Return a structure of measured or exported responses with further directions, and warnings about these."""
    findings = [
        line
        for direction, model in along.items()
        for line in response_findings(
            model.frequency_hz, model.values, tuple(f"{name} per {direction}" for name in structure.line_of_sight)
        )
    ]
    return replace(structure, directions=dict(along)).with_warnings(*findings)


def response_to_direction(frequency_hz: FloatArray, lines_of_sight: Sequence[ComplexArray]) -> FrequencyResponse:
    """Return the response of the lines of sight, (n,) each, to a force or torque along a direction at the interface."""
    unknown = np.full(frequency_hz.size, np.nan, dtype=np.complex128)
    return FrequencyResponse(frequency_hz, np.column_stack([unknown, *lines_of_sight]))


def structure_of_responses(
    label: str, frequency_hz: FloatArray, found: Mapping[str, ComplexArray], axis: str = ""
) -> Structure:
    """Return the structure of named receptances, (n,) each: at least one line of sight, optionally ``interface``."""
    names = tuple(name for name in found if name != INTERFACE)
    if not names:
        raise InputFileError(f'{label}: no line of sight; give at least one response beside "{INTERFACE}"')
    for name, column in found.items():
        refuse_overflow(f"{label}: {name}", frequency_hz, np.abs(column) > LARGEST_RECEPTANCE)
    unknown = np.full(frequency_hz.size, np.nan, dtype=np.complex128)
    values = np.column_stack([found.get(INTERFACE, unknown), *(found[name] for name in names)])
    try:
        model = FrequencyResponse(frequency_hz, values)
    except InputFileError as error:
        raise InputFileError(f"{label}: {error}") from error
    findings = response_findings(frequency_hz, values, names)
    return Structure(name=label, line_of_sight=names, model=model, axis=axis, warnings=tuple(findings))


def receptance_of(
    frequency_hz: FloatArray, values: ComplexArray, unit: str | None, place: str, per: str = "N*m"
) -> ComplexArray:
    """Convert a response in `unit` to a receptance, (n,), in rad/(N m) for a torque or rad/N for a force.

    `per` is the unit of the torque or force.

    Raises
    ------
    InputFileError
        The unit does not fit such a response.
    """
    kinds = {si.replace("N*m", per): differentiated for si, differentiated in KINDS.items()}
    for si, differentiated in kinds.items():
        factor = conversion_factor(unit or f"rad/({per})", si)
        if factor is not None:
            return to_receptance(frequency_hz, factor * values[:, None], differentiated)[:, 0]
    what = "torque" if per == "N*m" else "force"
    raise InputFileError(f'{place}: unit "{unit}" does not fit a response to a {what}; expected {", ".join(kinds)}')


def response_names(columns: Mapping[str, Column], label: str) -> dict[str, None]:
    """Return the names of the responses, each a pair of columns; raise InputFileError for other columns."""
    ends = [end for pair in PAIRS for end in pair]
    for name in columns:
        if is_decibel(name):
            raise InputFileError(f'{label}: column "{name}": is a level in dB; {LINEAR}, in a column that ends in _mag')
        if not name.endswith(tuple(ends)):
            raise InputFileError(
                f'{label}: column "{name}": end it with {", ".join(dict.fromkeys(ends))}, or leave it out'
            )
    return dict.fromkeys(name.removesuffix(next(e for e in ends if name.endswith(e))) for name in columns)


def _complex_response(
    name: str, columns: Mapping[str, Column], frequency_hz: FloatArray, label: str, per: str = "N*m"
) -> ComplexArray:
    values, unit, place = read_pair(name, columns, frequency_hz, label)
    return receptance_of(frequency_hz, values, unit, place, per)


def read_pair(
    name: str, columns: Mapping[str, Column], frequency_hz: FloatArray, label: str
) -> tuple[ComplexArray, str | None, str]:
    """Return a complex response from its pair of columns, (n,), its unit if there is one, and its place for messages.

    Raises
    ------
    InputFileError
        A column of the pair is missing, is a level in dB, or has another unit than the first.
    """
    first, second = _suffixes_of_pair(name, columns, label)
    (a, unit), (b, other) = columns[name + first], columns[name + second]
    place = f'{label}: column "{name}{first}"'
    if first == "_mag":
        refuse_levels(a, unit, place)
        phase_rad = _phase(name + second, b, other, a, label)
        if unit is None:
            refuse_hidden_levels(frequency_hz, a, phase_rad, place)
        return from_polar(a, phase_rad), unit, place
    if other not in (unit, None):
        raise InputFileError(f'{label}: column "{name}{second}": unit "{other}" where {name}{first} has "{unit}"')
    return np.asarray(a + 1j * b, dtype=np.complex128), unit, place


def _suffixes_of_pair(name: str, columns: Mapping[str, Column], label: str) -> tuple[str, str]:
    """Return the suffixes of a response's two columns; raise InputFileError if they are not a pair."""
    there = [end for end in dict.fromkeys(end for pair in PAIRS for end in pair) if name + end in columns]
    if len(there) == 2 and tuple(there) in PAIRS:
        return there[0], there[1]
    wanted = next(pair for pair in PAIRS if there[0] in pair)
    if len(there) == 1:
        missing = wanted[1] if there[0] == wanted[0] else wanted[0]
        raise InputFileError(
            f'{label}: no column "{name}{missing}"; a response is a pair, {name}{wanted[0]}, {name}{wanted[1]}'
        )
    held = ", ".join(f"{name}{end}" for end in there)
    raise InputFileError(f"{label}: found {held}; a response is one pair, {name}{wanted[0]}, {name}{wanted[1]}")


def _phase(column: str, phase: FloatArray, stated: str | None, magnitude: FloatArray, label: str) -> FloatArray:
    """Return a phase column in rad, (n,), according to the unit in brackets or the suffix of its name."""
    place, ending = f'{label}: column "{column}"', column.rpartition("_")[2]
    named = ending if ending in ("deg", "rad") else None
    unit = {None: None, "°": "deg", "degree": "deg", "degrees": "deg"}.get(stated, stated)
    if unit not in ("deg", "rad", None) or (unit is None and named is None) or (named and unit not in (named, None)):
        found = f'has unit "{stated}"' if stated is not None else "states no unit"
        raise InputFileError(f"{place}: {found}; end the name with _phase [deg] or _phase [rad]")
    return phase_in_radians(phase, str(unit or named), magnitude, place, is_stated=unit is not None)
