"""Tables, time series and Simulink's Datasets in .mat files of both kinds. Truth: the arrays that were written."""

import os
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from mechid.errors import RecordError
from mechid.records import ChannelSpec, RecordSpec, read_record
from mechid.records.formats import open_table
from mechid.records.table import Clock
from object_files import SELF, Obj, write_7, write_73

RATE = 1000.0
TIME = np.arange(200)[:, None] / RATE
TORQUE = np.sin(40.0 * TIME)
CURRENT = np.cos(40.0 * TIME)
WRITERS = {"7": write_7, "7.3": write_73}


def number(value):
    return np.array([[value]], dtype=float)


def series(data, name="", time=None, unit=""):
    """Return a time series: by a regular clock from 0.5 s, or by its own time."""
    even = {"Increment_": number(1.0 / RATE), "Start_": number(0.5), "Length": number(data.size)}
    info = Obj("tsdata.timemetadata", even if time is None else {"Time_": time, "Units": "seconds"})
    told = {"Units": unit} if unit else {"UserData": np.empty((0, 0))}
    own = {"Name": name} if name else {}
    return Obj("timeseries", {**own, "TimeInfo": info, "DataInfo": Obj("tsdata.datametadata", told), "Data_": data})


def dataset(*signals):
    """Return a Simulink Dataset of signals: their name and values."""
    elements = [
        Obj(
            "Simulink.SimulationData.Signal",
            {
                "Values": values,
                **({"Name": name} if name else {}),
                "BlockPath": Obj("Simulink.SimulationData.BlockPath", {"path": ["rig/Encoder"]}),
            },
        )
        for name, values in signals
    ]
    storage = Obj("Simulink.SimulationData.Storage.RamDatasetStorage", {"any": {"Elements": elements}}, saved=True)
    return Obj("Simulink.SimulationData.Dataset", {"any": {"Name": "logsout", "Storage": storage}}, saved=True)


VARIABLES = {
    "run": Obj(
        "table", {"data": [TIME, 1e3 * TORQUE], "varnames": ["time", "Mz"], "props": {"VariableUnits": ["s", "mN*m"]}}
    ),
    "stamped": Obj(
        "timetable",
        {
            "any": {
                "data": [TORQUE],
                "varNames": ["Mz"],
                "dimNames": ["Time", "Variables"],
                "varUnits": ["N*m"],
                "rowTimes": Obj("duration", {"millis": 1e3 * TIME}),
            }
        },
        saved=True,
    ),
    "rated": Obj(
        "timetable",
        {
            "any": {
                "data": [TORQUE],
                "varNames": ["Mz"],
                "rowTimes": {
                    "sampleRate": number(RATE),
                    "specifiedAsRate": number(1.0),
                    "origin": Obj("duration", {"millis": number(2500.0)}),
                    "stepSize": np.empty((0, 0)),
                },
            }
        },
        saved=True,
    ),
    "ts": series(TORQUE, unit="N*m"),
    "uneven": series(TORQUE, time=TIME),
    "logsout": dataset(
        ("torque", series(TORQUE)), ("", series(CURRENT)), ("twice", series(TORQUE)), ("twice", series(CURRENT))
    ),
    "out": Obj("Simulink.SimulationOutput", {"Data": {"logs": dataset(("current", series(CURRENT))), "tout": TIME}}),
    "own": Obj("rig.Run", {"torque_": TORQUE, "serial": "T-12", "rate": number(RATE)}),
    "text": Obj("string", {"any": np.array([[1, 2, 3]], dtype=np.int32)}, saved=True),
}
EVEN = Clock(0.5, RATE)
COLUMNS = {
    "run/time": (TIME, "time", "s", None),
    "run/Mz": (1e3 * TORQUE, "Mz", "mN*m", None),
    "stamped/Time": (TIME, "Time", "s", None),
    "stamped/Mz": (TORQUE, "Mz", "N*m", None),
    "rated/Mz": (TORQUE, "Mz", None, Clock(2.5, RATE)),
    "ts": (TORQUE, "ts", "N*m", EVEN),
    "uneven/Time": (TIME, "Time", "seconds", None),
    "uneven/Data": (TORQUE, "uneven", None, None),
    "logsout/torque": (TORQUE, "torque", None, EVEN),
    "logsout/Encoder": (CURRENT, "Encoder", None, EVEN),
    "logsout/twice/2": (TORQUE, "twice", None, EVEN),
    "logsout/twice/3": (CURRENT, "twice", None, EVEN),
    "out/logs/current": (CURRENT, "current", None, EVEN),
    "out/tout": (TIME, "tout", None, None),
    "own/torque": (TORQUE, "torque", None, None),
}


def record_of(path, *channels):
    """Return the record of a file with these channels."""
    return read_record(path, RecordSpec(name="run", path=str(path), channels=channels))


@pytest.fixture(params=WRITERS)
def file(request, tmp_path):
    path = tmp_path / "run.mat"
    WRITERS[request.param](path, VARIABLES)
    return path


def test_what_objects_hold_are_columns(file):
    opened = open_table(file, file.name)
    found = {column.key: (index, column) for index, column in enumerate(opened.columns) if not column.fault}
    assert found.keys() == COLUMNS.keys()
    for key, (values, name, unit, clock) in COLUMNS.items():
        index, column = found[key]
        assert (column.name, column.unit, column.clock) == (name, unit, clock), key
        np.testing.assert_allclose(opened.read([index])[0], values.ravel(), rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(opened.read([index], slice(7, 60))[0], values.ravel()[7:60], rtol=1e-12, atol=1e-12)
    assert opened.metadata["own/rate"] == RATE


def test_a_record_is_read_from_a_table_and_from_a_dataset(file):
    record = record_of(file, ChannelSpec(quantity="torque", column="run/Mz"))
    np.testing.assert_allclose(record.channel("torque").data, TORQUE.ravel(), rtol=1e-12, atol=1e-12)
    assert (record.sample_rate_hz, record.time_start_s) == (pytest.approx(RATE), 0.0)
    both = (ChannelSpec(quantity="torque", column="logsout/torque"), ChannelSpec(quantity="current", column="Encoder"))
    record = record_of(file, *both)
    np.testing.assert_allclose(record.channel("current").data, CURRENT.ravel(), rtol=1e-12)
    assert (record.sample_rate_hz, record.time_start_s) == (RATE, 0.5)


def test_an_object_without_numbers_is_answered_with_matlab_s_line(file):
    with pytest.raises(RecordError, match=r'class "string" without a readable array of numbers; in MATLAB save'):
        record_of(file, ChannelSpec(quantity="torque", column="text"))


@pytest.mark.parametrize("version", WRITERS)
def test_an_object_that_holds_itself_is_read_once(version, tmp_path):
    """A handle, as a part that knows what it is a part of. Truth: its other properties."""
    parts = [Obj("rig.Part", {"torque": TORQUE}), Obj("rig.Part", {"whole": SELF, "rate": CURRENT})]
    path = tmp_path / "run.mat"
    WRITERS[version](path, {"whole": Obj("rig.Whole", {"parts": parts})})
    opened = open_table(path, path.name)
    assert {column.key for column in opened.columns} == {"whole/parts/0/torque", "whole/parts/1/rate"}


@pytest.mark.parametrize("layout", ["structure with time", "array"])
def test_simulink_s_other_formats_are_plain(layout, tmp_path):
    """A "To Workspace" block's structure with time (time, signals.values, signals.label), and its array [t, u, v]."""
    path = tmp_path / "run.mat"
    signals = {"values": np.hstack([TORQUE, CURRENT]), "dimensions": 2.0, "label": "rig"}
    saved = {
        "structure with time": {"time": TIME, "signals": signals, "blockName": "rig/Out"},
        "array": np.hstack([TIME, TORQUE, CURRENT]),
    }
    scipy.io.savemat(path, {"run": saved[layout]})
    place = "run/signals/values/{}" if layout == "structure with time" else "run/{}"
    first = 0 if layout == "structure with time" else 1
    channels = [ChannelSpec(quantity=q, column=place.format(first + k)) for k, q in enumerate(("torque", "current"))]
    time = ChannelSpec(quantity="time", column="run/0") if layout == "array" else None
    record = read_record(path, RecordSpec(name="run", path=str(path), channels=tuple(channels), time=time))
    assert record.sample_rate_hz == pytest.approx(RATE)
    np.testing.assert_array_equal(record.channel("current").data, CURRENT.ravel())


@pytest.mark.parametrize("version", WRITERS)
def test_a_table_of_objects_of_another_version_is_told(version, tmp_path, monkeypatch):
    """Truth: version 9 is none that anybody has described."""
    path = tmp_path / "run.mat"
    monkeypatch.setattr("object_files.VERSION", 9)
    WRITERS[version](path, {"ts": VARIABLES["ts"]})
    opened = open_table(path, path.name)
    assert ['class "timeseries"' in column.fault for column in opened.columns] == [True]
    assert "t = x.Time; y = x.Data" in opened.columns[0].fault


SIGNALS = {
    "torque": {"DataR2": 0},
    "i": {"DataR2": 1},
    "uneven": {"DataR2": 2, "TimeR2": 3},
    "single": {"DataR2": 5},
}
"""Signals of a Dataset, and the numbers of their streams."""


def stream(file, number, data, size=8):
    """Write a stream of samples as bytes."""
    group = file.create_group(f"#sigstream#/{number}")
    group["#data#"] = np.frombuffer(data.astype("<f8" if size == 8 else "<f4").tobytes(), np.uint8)
    group["#length#"], group["#sampleSize#"] = np.array([float(data.size)]), np.array([float(size)])


def test_signals_that_simulink_logged_into_streams_are_read(tmp_path):
    """Two with a compressed time, one with a time of its own, one of four bytes, one that no element names."""
    import h5py

    path = tmp_path / "logged.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        for number, data in enumerate((TORQUE, CURRENT, TORQUE, TIME, TORQUE)):
            stream(file, number, data.ravel())
        stream(file, 5, TORQUE.ravel(), size=4)
        for name, streams in SIGNALS.items():
            element = file.create_group(f"#refs#/{name[0]}")
            element["Name"] = np.array([[ord(letter)] for letter in name], np.uint16)
            for entry, number in streams.items():
                element[f"Values/{entry}"] = np.array([[float(number)]])
            if "TimeR2" not in streams:
                element["Values/CompressedTime"] = np.array([[0.5, 1.0 / RATE, TIME.size]])
        file["data"] = np.array([[0xDD000000, 2, 1, 1, 1, 1]], np.uint32)
        file["data"].attrs["MATLAB_class"] = np.bytes_("Simulink.SimulationData.Dataset")
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, written by a test".ljust(512))
    opened = open_table(path, path.name)
    found = {
        column.key: (opened.read([k])[0], column.clock) for k, column in enumerate(opened.columns) if not column.fault
    }
    expected = {
        "torque": (TORQUE, EVEN),
        "i": (CURRENT, EVEN),
        "uneven/Data": (TORQUE, None),
        "uneven/Time": (TIME, None),
        "#sigstream#/4": (TORQUE, None),
    }
    assert found.keys() == expected.keys()
    for key, (values, clock) in expected.items():
        np.testing.assert_array_equal(found[key][0], values.ravel())
        assert found[key][1] == clock
    faults = {column.key: column.fault for column in opened.columns if column.fault}
    assert list(faults) == ["single"]
    assert "4 bytes each, whose class the file does not state" in faults["single"]
    assert record_of(path, ChannelSpec(quantity="torque", column="torque")).time_start_s == 0.5
    index = [column.key for column in opened.columns].index("i")
    np.testing.assert_array_equal(opened.read([index], slice(10, 50))[0], CURRENT.ravel()[10:50])


@pytest.mark.parametrize("version", ["v7", "v73"])
def test_files_that_matlab_wrote(version):
    """Truth: what the tests of mat-io say of its files; MECHID_MAT_OBJECTS is the folder that holds them."""
    folder = os.environ.get("MECHID_MAT_OBJECTS")
    if not folder:
        pytest.skip("no files of MATLAB's objects here; set MECHID_MAT_OBJECTS to mat-io's tests/data")
    path = Path(folder) / f"test_tables_{version}.mat"
    opened = open_table(path, path.name)
    keys = {column.key: index for index, column in enumerate(opened.columns)}
    for key, expected in {
        "table_numeric/Var1": [1.1, 2.2, 3.3],
        "table_var_names/Y": [100.0, 200.0, 300.0],
        "table_time/Duration": [30.0, 60.0, 90.0],
        "timetable_datetime/Time": [0.0, 86400.0, 172800.0],
        "timetable_duration/Time": [10.0, 20.0, 30.0],
        "timetable_multi_col/data2/1": [4.0, 5.0, 6.0],
    }.items():
        np.testing.assert_allclose(opened.read([keys[key]])[0], expected, rtol=1e-15)
    clocks = {column.key: column.clock for column in opened.columns}
    assert clocks["timetable_from_sample_rate/data1"] == Clock(0.0, 10_000.0)
    assert opened.columns[keys["timetable_with_attrs/data1"]].unit == "m/s"
    assert opened.columns[keys["timetable_datetime/Time"]].start_time == "2023-01-01T00:00:00.000"
