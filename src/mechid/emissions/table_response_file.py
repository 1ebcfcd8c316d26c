"""Readers of a table's response from CSV, universal (data set 58) and MAT files.

A response is that of a measured load to a load on the table, by the names of the directions: ``fx_fx`` or ``fx`` is Fx
measured per Fx applied, ``mx_fy`` is Mx measured per Fy applied. Those that a file does not have are zero, off the
diagonal; a component that was not applied and measured itself is not known.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat, matlab

from mechid.arrays import ComplexArray, FloatArray
from mechid.campaign.table_response_entry import DIRECTIONS, DeclaredResponse
from mechid.emissions.table_response import SIX, MeasuredTable, ModalTable, TableResponse
from mechid.errors import InputFileError
from mechid.reading.process import read_guarded
from mechid.structure.response_csv import read_columns, read_pair, response_names
from mechid.structure.uff import axis_label, read_sets
from mechid.units import conversion_factor
from mechid.writing import mark_as_read

LEAST_POINTS = 8
SI = ("N", "N", "N", "N*m", "N*m", "N*m")
UNITS_REMEDY = 'write input_unit = ["N", "N*m"] and output_unit = ["N", "N*m"], those of the load and of the table'
RESPONSE_TYPES = (4, 9)
"""UFF function types of a frequency response and of a transmissibility."""
MOTIONS = {8: "a displacement", 11: "a velocity", 12: "an acceleration"}
"""UFF data types that are no loads."""
Pairs = dict[tuple[int, int], ComplexArray]


def table_response_of(declared: DeclaredResponse) -> TableResponse:
    """Return the response of a table as its modes or its file give it.

    Raises
    ------
    InputFileError
        The file cannot be read, states no units, or is no response to loads.
    """
    if declared.file is None:
        return ModalTable(
            modes=declared.modes, uncertainty=declared.uncertainty, damping_uncertainty=declared.damping_uncertainty
        )
    mark_as_read(declared.file)
    try:
        frequency, pairs = _read(declared.file, declared)
        return _table(frequency, pairs, declared)
    except OSError as error:
        message = f"{declared.file.name}: cannot be read ({error.strerror or error}); check the path"
    except InputFileError as error:
        message = str(error)
    raise declared.place.key("file").error(message)


def _read(path: Path, declared: DeclaredResponse) -> tuple[FloatArray, Pairs]:
    suffix = path.suffix.lower()
    if suffix == ".csv":
        return _read_csv(path, declared)
    reader: Callable[[Path], Any] = _load_mat if suffix == ".mat" else _load_uff
    content = read_guarded(reader, path, kind="of responses")
    return (_mat if suffix == ".mat" else _uff)(content, path.name, declared)


def _table(frequency: FloatArray, pairs: Pairs, declared: DeclaredResponse) -> MeasuredTable:
    label = declared.file.name if declared.file else ""
    if frequency.size < LEAST_POINTS:
        raise InputFileError(f"{label}: {frequency.size} frequencies; a response needs at least {LEAST_POINTS}")
    if not np.all(np.diff(frequency) > 0.0) or frequency[0] < 0.0:
        k = int(np.argmin(np.diff(frequency)))
        raise InputFileError(
            f"{label}: frequency {frequency[k + 1]:.9g} Hz after {frequency[k]:.9g} Hz; sort the points"
        )
    measured = tuple(k for k in range(SIX) if (k, k) in pairs)
    for row, column in pairs:
        if row not in measured or column not in measured:
            lacking = DIRECTIONS[row if row not in measured else column]
            raise InputFileError(
                f"{label}: has {DIRECTIONS[row]} per {DIRECTIONS[column]}, but not {lacking} per {lacking}; the "
                "response of each component to itself is needed"
            )
    values = np.tile(np.eye(SIX, dtype=np.complex128), (frequency.size, 1, 1))
    for (row, column), response in pairs.items():
        if not np.isfinite(response).all():
            raise InputFileError(
                f"{label}: {DIRECTIONS[row]} per {DIRECTIONS[column]}: holds a value that is not finite"
            )
        values[:, row, column] = response
    return MeasuredTable(frequency_hz=frequency, values=values, measured=measured, uncertainty=declared.uncertainty)


def _factor(row: int, column: int, unit: str | None, declared: DeclaredResponse, place: str) -> float:
    """Return the factor to N and N m of a response, by its unit in the file or those of the campaign."""
    if unit is not None:
        # A response of a component to itself may be stated without a dimension.
        factor = conversion_factor(unit, f"{SI[row]}/({SI[column]})" if SI[row] != SI[column] else "1")
        if factor is None:
            raise InputFileError(
                f'{place}: unit "{unit}" is none of {DIRECTIONS[row]} per {DIRECTIONS[column]}; expected '
                f"{SI[row]}/({SI[column]})"
            )
        return factor
    if declared.input_factors is None or declared.output_factors is None:
        raise InputFileError(f"{place}: states no unit; {UNITS_REMEDY}")
    return float(declared.output_factors[row] / declared.input_factors[column])


def _named_pair(name: str, label: str) -> tuple[int, int]:
    measured, _, applied = name.lower().partition("_")
    words = (measured, applied or measured)
    for word in words:
        if word not in DIRECTIONS:
            raise InputFileError(
                f'{label}: "{name}" is no response of a table; name it by directions, as fx_re or mx_fy_re, of '
                f"{', '.join(DIRECTIONS)}"
            )
    return DIRECTIONS.index(words[0]), DIRECTIONS.index(words[1])


def _read_csv(path: Path, declared: DeclaredResponse) -> tuple[FloatArray, Pairs]:
    frequency, columns = read_columns(path)
    pairs: Pairs = {}
    for name in response_names(columns, path.name):
        at = _named_pair(name, path.name)
        if at in pairs:
            raise InputFileError(f'{path.name}: "{name}" stands there twice; keep one')
        values, unit, place = read_pair(name, columns, frequency, path.name)
        pairs[at] = _factor(*at, unit, declared, place) * values
    return frequency, pairs


def _load_mat(path: Path) -> dict[str, Any]:
    try:
        content = loadmat(path)
    except NotImplementedError as error:
        raise InputFileError(f'{path.name}: is of version 7.3; save it with "-v7"') from error
    except (matlab.MatReadError, ValueError) as error:
        raise InputFileError(f"{path.name}: is not a MAT file ({error}); export or copy it again") from error
    return {key: np.asarray(value) for key, value in content.items() if not key.startswith("__")}


def _mat(content: Mapping[str, Any], label: str, declared: DeclaredResponse) -> tuple[FloatArray, Pairs]:
    for name in ("frequency_hz", "response"):
        if name not in content or content[name].dtype.kind not in "fiuc":
            held = ", ".join(content) or "none"
            raise InputFileError(
                f'{label}: no numbers under "{name}"; expected frequency_hz and response, found {held}'
            )
    frequency = np.ravel(content["frequency_hz"]).astype(np.float64)
    values = np.asarray(content["response"], dtype=np.complex128)
    n = frequency.size
    # MATLAB programs keep the frequency as the last dimension as often as the first.
    if values.shape in ((SIX, SIX, n), (SIX, n)):
        values = np.moveaxis(values, -1, 0)
    if values.shape == (n, SIX):
        at: list[tuple[int, int]] = [(k, k) for k in range(SIX)]
        values = np.stack([np.diag(row) for row in values])
    elif values.shape == (n, SIX, SIX):
        at = [(row, column) for row in range(SIX) for column in range(SIX)]
    else:
        raise InputFileError(
            f"{label}: response is {'x'.join(map(str, values.shape))}; expected {n}x6x6 (all pairs) or {n}x6 "
            f"(per axis), since frequency_hz has {n} values"
        )
    pairs = {
        (row, column): _factor(row, column, None, declared, f"{label}: response") * values[:, row, column]
        for row, column in at
    }
    return frequency, pairs


def _load_uff(path: Path) -> list[dict[str, Any]]:
    wanted = (
        *("func_type", "rsp_node", "rsp_dir", "ref_node", "ref_dir", "x", "data"),
        *("ordinate_spec_data_type", "ordinate_axis_units_lab", "orddenom_axis_units_lab"),
    )
    return [{key: entry[key] for key in wanted if key in entry} for entry in read_sets(path)]


def _uff(sets: list[dict[str, Any]], label: str, declared: DeclaredResponse) -> tuple[FloatArray, Pairs]:
    found = [entry for entry in sets if int(entry.get("func_type", 0)) in RESPONSE_TYPES]
    if not found:
        raise InputFileError(f"{label}: holds no frequency response in a data set 58")
    frequency = np.asarray(found[0]["x"], dtype=np.float64)
    pairs: Pairs = {}
    for entry in found:
        directions = [int(entry["rsp_dir"]), int(entry["ref_dir"])]
        if not all(1 <= abs(one) <= SIX for one in directions):
            raise InputFileError(f"{label}: direction {directions[0]} to {directions[1]}: expected 1 to 6, fx to mz")
        row, column = (abs(one) - 1 for one in directions)
        place = f"{label}: {DIRECTIONS[row]} per {DIRECTIONS[column]}"
        if (row, column) in pairs:
            raise InputFileError(f"{place}: stands there twice; keep the one at the interface")
        motion = MOTIONS.get(int(entry.get("ordinate_spec_data_type", 0) or 0))
        if motion:
            raise InputFileError(f"{place}: is {motion} per load; export the table's own loads per load")
        f = np.asarray(entry["x"], dtype=np.float64)
        if f.shape != frequency.shape or not np.allclose(f, frequency):
            raise InputFileError(f"{place}: has other frequencies than the first; export all at the same ones")
        labels = [axis_label(entry, which) for which in ("ordinate", "orddenom")]
        unit = f"{labels[0]}/({labels[1]})" if all(labels) else None
        sign = float(np.sign(directions[0]) * np.sign(directions[1]))
        values = np.asarray(entry["data"], dtype=np.complex128)
        pairs[row, column] = sign * _factor(row, column, unit, declared, place) * values
    return frequency, pairs
