"""Records from samples in memory: arrays, data frames and data sets are treated like the columns of a file.

Pandas and xarray are not imported; their objects are recognised by their attributes.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mechid.errors import RecordError
from mechid.records.arrays import ArrayTable, Item, array_table
from mechid.records.column_names import is_time
from mechid.records.formats import record_from
from mechid.records.record import Record
from mechid.records.scaling import Attributes, is_applied, plain_unit, read_packing
from mechid.records.spec import RecordSpec
from mechid.records.table import Clock, Column
from mechid.units import to_si_factor

KIND = "samples in memory"
MEMORY = Path("memory:")
"""Placeholder for the folder in paths of samples that are not in a file."""
DATES = "it holds dates, no measured numbers"
TIME, TORQUE = "time_s", "torque"


@dataclass(frozen=True, kw_only=True, eq=False)
class SampleColumns:
    """Named series of equal length, like the columns of a file.

    Parameters
    ----------
    arrays : mapping of str to (n,) array
        Series by column name, which may contain a unit like a file's header; `TIME` is the time in s.
    units : mapping of str to str
        Units stated separately from the names.
    attributes : mapping of str to mapping
        Further attributes of columns, such as those of an xarray object; they may include an unapplied scaling.
    """

    arrays: Mapping[str, NDArray[Any]]
    units: Mapping[str, str] = field(default_factory=dict)
    attributes: Mapping[str, Attributes] = field(default_factory=dict)

    @property
    def digest(self) -> str:
        """SHA-256 digest of names and samples in hexadecimal notation."""
        found = hashlib.sha256()
        for name, array in self.arrays.items():
            found.update(name.encode())
            found.update(np.ascontiguousarray(array).tobytes())
        return found.hexdigest()


def columns_of(samples: object, label: str) -> SampleColumns:
    """Return the columns of an array (torque in N m), a mapping of arrays, a DataFrame, Series, Dataset or DataArray.

    The index of a pandas object and the single dimension of an xarray object are the time in s; dates are converted to
    seconds since the first one. A plain count (a RangeIndex, a dimension without coordinate) is not a time.

    Raises
    ------
    RecordError
        The samples are none of these, or have more than one dimension.
    """
    if hasattr(samples, "data_vars"):
        return _columns_of_dataset(samples, label)
    if hasattr(samples, "coords") and hasattr(samples, "dims"):
        return _columns_of_dataset(samples.to_dataset(name=samples.name or TORQUE), label)  # type: ignore[attr-defined]
    if hasattr(samples, "columns") and hasattr(samples, "index"):
        named = {str(name): _array(samples[name]) for name in samples.columns}  # type: ignore[index]
        return _unpack_columns(_time_of_index(samples.index) | named, _attributes_of_columns(samples, tuple(named)))
    if hasattr(samples, "index") and hasattr(samples, "name") and not callable(samples.index):
        name = str(samples.name or TORQUE)
        return _unpack_columns(_time_of_index(samples.index) | {name: _array(samples)}, {name: _attributes(samples)})
    if isinstance(samples, Mapping):
        return SampleColumns(arrays={str(name): _array(array) for name, array in samples.items()})
    array = _array(samples)
    if array.ndim != 1:
        sizes = " x ".join(map(str, array.shape)) or "one value"
        raise RecordError(f"{label}: found {sizes}; give the torque as one series, or a mapping of series by name")
    return SampleColumns(arrays={TORQUE: array})


def record_of(columns: SampleColumns, spec: RecordSpec) -> Record:
    """Return the record of samples in memory, selected, checked and conditioned like those of a file.

    Parameters
    ----------
    columns : SampleColumns
    spec : RecordSpec
        If it has a `sample_rate_hz` and the samples have no times, they begin at record time 0.

    Raises
    ------
    RecordError
        The samples are not usable; the message has one line.
    """
    rate = spec.sample_rate_hz
    # A rate is checked against the times.
    if rate is None or _has_times(columns):
        return record_from(MEMORY / spec.path, spec, _table(columns, spec.path), columns.digest)
    table = _table(columns, spec.path, Clock(0.0, rate))
    return record_from(MEMORY / spec.path, replace(spec, sample_rate_hz=None), table, columns.digest)


def _has_times(columns: SampleColumns) -> bool:
    """Return whether the samples have times; integers, such as the index after a selection of rows, are a count."""
    return any(_is_time(name) and array.dtype.kind not in "iu" for name, array in columns.arrays.items())


def _array(values: Any) -> NDArray[Any]:
    """Return values as an array in which masked values are NaN, that is, missing samples."""
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        return np.ma.filled(values.astype(np.float64), np.nan)
    return np.asarray(values)


def _table(columns: SampleColumns, label: str, clock: Clock | None = None) -> ArrayTable:
    items = [
        Item(
            column=_column(name, array, columns.units.get(name), clock),
            shape=array.shape,
            dtype=array.dtype,
            load=array.__getitem__,
            attributes=columns.attributes.get(name, {}),
        )
        for name, array in columns.arrays.items()
        if not (clock and name == TIME)
    ]
    return array_table(label, KIND, items, {}, is_sliced=True)


def _column(name: str, array: NDArray[Any], unit: str | None, clock: Clock | None) -> Column:
    fault = DATES if array.dtype.kind == "M" and not _is_time(name) else None
    return Column(name=name, unit=unit, clock=clock, fault=fault)


def _is_time(name: str) -> bool:
    return is_time(Column(name=name))


def _columns_of_dataset(samples: Any, label: str) -> SampleColumns:
    if len(samples.sizes) != 1:
        raise RecordError(f"{label}: found the dimensions {', '.join(map(str, samples.sizes))}; give one, the time")
    (dimension,) = samples.sizes
    arrays = {str(name): np.asarray(one) for name, one in samples.data_vars.items()}
    attributes = {str(name): _attributes(one) for name, one in samples.data_vars.items()}
    if dimension in samples.coords:
        arrays = {TIME: _coordinate(samples.coords[dimension], label)} | arrays
    return _unpack_columns(arrays, attributes)


def _attributes(samples: Any) -> Attributes:
    """Return the attributes of a Series or a DataArray."""
    # xarray stores the attributes of values that it has decoded itself elsewhere, so no scaling is applied twice.
    return dict(getattr(samples, "attrs", {}))


def _attributes_of_columns(frame: Any, names: tuple[str, ...]) -> dict[str, Attributes]:
    """Return the attributes of a DataFrame's columns: those under a column's name, or all for a single column."""
    stated = _attributes(frame)
    if len(names) == 1 and not isinstance(stated.get(names[0]), Mapping):
        return {names[0]: stated}
    return {name: dict(stated[name]) for name in names if isinstance(stated.get(name), Mapping)}


def _unpack_columns(arrays: Mapping[str, NDArray[Any]], attributes: Mapping[str, Attributes]) -> SampleColumns:
    """Return columns with units, unpacked according to their attributes; unapplied attributes are kept."""
    units, unpacked, others = {}, dict(arrays), {}
    for name, stated in attributes.items():
        packing = read_packing(stated, arrays[name].dtype)
        if packing:
            unpacked[name] = packing.unpack(arrays[name])
        if "units" in stated:
            units[name] = str(stated["units"])
        others[name] = {key: value for key, value in stated.items() if not is_applied(key, value)}
    return SampleColumns(arrays=unpacked, units=units, attributes=others)


def _coordinate(time: Any, label: str) -> NDArray[Any]:
    """Return a time coordinate in s."""
    array = np.asarray(time)
    stated = _attributes(time)
    if array.dtype.kind in "mM" or "units" not in stated:
        return _seconds(array)
    try:
        factor = to_si_factor(plain_unit(str(stated["units"])), "time")
    except RecordError as error:
        raise RecordError(f"{label}: time: {error}") from None
    return _unpack_columns({TIME: array}, {TIME: stated}).arrays[TIME] * factor


def _time_of_index(index: Any) -> dict[str, NDArray[Any]]:
    return {} if type(index).__name__ == "RangeIndex" else {TIME: _seconds(np.asarray(index))}


def _seconds(values: NDArray[Any]) -> NDArray[Any]:
    """Return times in s; dates are converted to seconds since the first one."""
    if values.dtype.kind not in "mM":
        return values
    since = values - values[0] if values.dtype.kind == "M" else values
    return np.asarray(since / np.timedelta64(1, "ns") * 1e-9)
