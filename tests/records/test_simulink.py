"""Signals that Simulink logged into .mat files of version 7.3, laid out as R2024b leaves them. Truth: what was written.

Empty entries hold their dimensions, (0, 0), with the attribute MATLAB_empty, as MATLAB writes them.
"""

from dataclasses import dataclass, field

import numpy as np
import pytest

from mechid.errors import RecordError
from mechid.records import ChannelSpec
from mechid.records.formats import open_table
from mechid.records.table import Clock
from mechid.records.undeclared import read_bare
from records_read import read, torque

RATE = 1000.0
TIME = np.arange(200) / RATE
TORQUE = np.sin(40.0 * TIME)
COUNTS = np.round(100.0 * TORQUE)


@dataclass
class Signal:
    """A time series: its samples, their class as Simulink names it, and its time (None: an even one)."""

    data: np.ndarray
    kind: str = "double"
    time: np.ndarray | None = None
    unit: str = ""
    resolved: str = ""
    changes: dict = field(default_factory=dict)


DTYPES = {"double": "<f8", "single": "<f4", "logical": "u1", "boolean": "u1", "half": "<f2", "Colour": "<i4"}


class Log:
    """A file of logged signals."""

    def __init__(self, file):
        self.file, self.streams, self.elements = file, 0, 0
        file.create_group("#sigstream#")

    def stream(self, data, dtype):
        group = self.file.create_group(f"#sigstream#/{self.streams}")
        group["#data#"] = np.frombuffer(np.ascontiguousarray(data, dtype=dtype).tobytes(), np.uint8)
        group["#length#"] = np.array([len(data)], np.uint64)
        group["#sampleSize#"] = np.array([np.dtype(dtype).itemsize * data[0].size], np.uint64)
        self.streams += 1
        return self.streams - 1

    def put(self, group, name, value):
        empty = value is None or (isinstance(value, str) and not value)
        if isinstance(value, str) and value:
            group[name] = np.array([[ord(letter)] for letter in value], np.uint16)
        else:
            group[name] = np.zeros(2, np.uint64) if empty else np.asarray(value)
        if empty:
            group[name].attrs["MATLAB_empty"] = np.uint8(1)

    def series(self, group, signal):
        """Write a time series into a group."""
        even = [[0.5], [1.0 / RATE], [float(len(signal.data))]]
        dtype = DTYPES.get(signal.kind, signal.kind)
        entries = {
            "DataR2": [[float(self.stream(signal.data, dtype))]],
            "TimeR2": None if signal.time is None else [[float(self.stream(signal.time, "<f8"))]],
            "CompressedTime": even if signal.time is None else None,
            "Time": None,
            "VarDimsR2": None,
            "DataUnits/Value": signal.unit,
            "TimeUnits/Value": "seconds",
            "SignalAttributes/ClassName": signal.kind,
            "SignalAttributes/ResolvedClassName": signal.resolved,
            "SignalAttributes/Complexity": [[0]],
        }
        for name, value in {**entries, **signal.changes}.items():
            self.put(group, name, value)

    def element(self, name, values):
        """Write an element of a Dataset: a signal, or a dict of them for a bus."""
        node = self.file.create_group(f"#refs#/{'abcdefghijk'[self.elements]}")
        self.elements += 1
        self.put(node, "Name", name)
        self.put(node, "DSMWritersR2", None)
        self.values(node.create_group("Values"), values)
        return node

    def values(self, group, values):
        if isinstance(values, Signal):
            self.series(group, values)
            return
        for name, part in values.items():
            self.values(group.create_group(name), part)


def written(path, signals, **more):
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        log = Log(file)
        for name, values in signals.items():
            log.element(name, values)
        for name, values in more.items():
            file[name] = values
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, written by a test".ljust(512))
    return path


def columns_of(path):
    opened = open_table(path, path.name)
    return {c.key: (c, None if c.fault else opened.read([k])[0]) for k, c in enumerate(opened.columns)}


KINDS = (
    "double",
    "single",
    "half",
    "int8",
    "int16",
    "int32",
    "int64",
    "uint8",
    "uint16",
    "uint32",
    "uint64",
    "logical",
)


@pytest.mark.parametrize("kind", KINDS)
def test_a_signal_is_read_by_its_class(kind, tmp_path):
    data = np.abs(COUNTS) > 50 if kind == "logical" else np.abs(COUNTS) if kind.startswith("uint") else COUNTS
    first = Signal(np.cos(TIME))
    found = columns_of(written(tmp_path / "run.mat", {"first": first, "torque": Signal(data, kind)}))
    assert set(found) == {"first", "torque"}
    column, values = found["torque"]
    np.testing.assert_array_equal(values, data.astype(float))
    assert column.clock == Clock(0.5, RATE)
    assert column.whole == (kind not in ("double", "single", "half"))


def test_an_empty_stream_is_not_that_of_another_signal(tmp_path):
    """Truth: two signals with even times; an empty TimeR2, which holds (0, 0), is not stream 0."""
    path = written(tmp_path / "run.mat", {"angle": Signal(np.cos(TIME)), "torque": Signal(TORQUE)})
    assert set(columns_of(path)) == {"angle", "torque"}
    record = read(path, torque("torque"))
    assert (record.time_start_s, record.sample_rate_hz) == (0.5, RATE)
    np.testing.assert_array_equal(record.channel("torque").data, TORQUE)


def test_a_signal_of_uneven_time_has_its_own(tmp_path):
    uneven = np.cumsum(1.0 + 0.5 * np.sin(np.arange(200.0))) / RATE
    found = columns_of(written(tmp_path / "run.mat", {"a": Signal(TORQUE), "b": Signal(COUNTS, "int16", uneven)}))
    assert set(found) == {"a", "b/Data", "b/Time"}
    np.testing.assert_array_equal(found["b/Time"][1], uneven)
    np.testing.assert_array_equal(found["b/Data"][1], COUNTS)
    assert found["b/Data"][0].clock is None


def test_the_unit_of_a_signal_is_read(tmp_path):
    path = written(tmp_path / "run.mat", {"torque": Signal(1e3 * TORQUE, "single", unit="mN*m")})
    np.testing.assert_allclose(read(path, torque("torque")).channel("torque").data, TORQUE, atol=1e-7)
    with pytest.raises(RecordError, match="its unit contradicts"):
        read(path, torque("torque", unit="N*m"))


def test_integers_of_a_log_are_doubted_beside_their_unit(tmp_path):
    path = written(tmp_path / "run.mat", {"torque": Signal(COUNTS, "int16", unit="N*m")})
    (warning,) = read(path, torque("torque")).warnings
    assert 'integers, read in "N*m" as the file says; are they raw counts?' in warning


def test_signals_of_a_bus_have_paths(tmp_path):
    bus = {"arm": {"torque": Signal(TORQUE), "i": Signal(COUNTS, "int32")}, "Time": Signal(TIME, time=TIME)}
    found = columns_of(written(tmp_path / "run.mat", {"rig": bus, "torque": Signal(COUNTS)}))
    assert set(found) == {"rig/arm/torque", "rig/arm/i", "rig/Time/Data", "rig/Time/Time", "torque"}
    np.testing.assert_array_equal(found["rig/arm/i"][1], COUNTS)


def test_vectors_are_series_side_by_side(tmp_path):
    path = written(tmp_path / "run.mat", {"rig": Signal(np.stack([TORQUE, COUNTS], axis=1), "single")})
    found = columns_of(path)
    assert set(found) == {"rig/0", "rig/1"}
    np.testing.assert_array_equal(found["rig/1"][1], COUNTS)
    np.testing.assert_allclose(read(path, torque("rig/0")).channel("torque").data, TORQUE, atol=1e-7)
    opened = open_table(path, path.name)
    np.testing.assert_array_equal(opened.read([1], slice(10, 50))[0], COUNTS[10:50])


def test_elements_of_one_name_are_told_apart(tmp_path):
    path = written(tmp_path / "run.mat", {"a": Signal(TORQUE), "b": Signal(COUNTS)})
    import h5py

    with h5py.File(path, "r+") as file:
        file.copy("#refs#/a", "#refs#/saved_again")  # as output and as variable: the same stream
    assert set(columns_of(path)) == {"a", "b"}
    with h5py.File(path, "r+") as file:
        del file["#refs#/b/Name"]
        file["#refs#/b/Name"] = np.array([[ord("a")]], np.uint16)
    assert set(columns_of(path)) == {"a/a", "a/b"}


FAULTS = {
    "an unknown class": (Signal(COUNTS, "<i4", changes={"SignalAttributes/ClassName": "embedded.fi"}), "embedded.fi"),
    "complex samples": (Signal(COUNTS, changes={"SignalAttributes/Complexity": [[1]]}), "complex double"),
    "a variable size": (Signal(COUNTS, changes={"VarDimsR2": [[0.0]]}), "signal of variable size"),
    "another size": (Signal(COUNTS, "<f4", changes={"SignalAttributes/ClassName": "double"}), "samples of 4 bytes"),
    "a stream that is not there": (Signal(COUNTS, changes={"DataR2": [[9.0]]}), "stream 9 is not in the file"),
    "another count": (Signal(COUNTS, changes={"CompressedTime": [[0.0], [1e-3], [7.0]]}), "its time has 7 samples"),
    "an unknown unit of time": (Signal(COUNTS, changes={"TimeUnits/Value": "furlongs"}), "its time: "),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_signal_that_cannot_be_read_says_why(name, tmp_path):
    signal, said = FAULTS[name]
    path = written(tmp_path / "run.mat", {"torque": signal, "other": Signal(TORQUE)})
    column, _ = columns_of(path)["torque"]
    assert said in column.fault
    with pytest.raises(RecordError, match='torque: column "torque": '):
        read(path)
    assert any(said in line for line in read_bare(path)[0].warnings)


def test_an_enumeration_is_read_as_what_it_resolves_to(tmp_path):
    path = written(tmp_path / "run.mat", {"torque": Signal(COUNTS, "Colour", resolved="int32")})
    np.testing.assert_array_equal(columns_of(path)["torque"][1], COUNTS)


def test_a_signal_without_samples_is_left_out(tmp_path):
    path = written(tmp_path / "run.mat", {"empty": Signal(COUNTS, changes={"DataR2": None}), "torque": Signal(TORQUE)})
    assert set(columns_of(path)) == {"#sigstream#/0", "torque"}


def test_time_in_minutes_is_converted(tmp_path):
    path = written(tmp_path / "run.mat", {"torque": Signal(TORQUE, changes={"TimeUnits/Value": "min"})})
    record = read(path, ChannelSpec(quantity="torque", column="torque"))
    assert (record.time_start_s, record.sample_rate_hz) == (pytest.approx(30.0), pytest.approx(RATE / 60.0))
