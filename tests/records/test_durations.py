"""Durations and dates as the time, of every format that has them. Truth: the seconds that they were made from."""

import numpy as np
import pytest

from mechid.errors import RecordError
from mechid.records import ChannelSpec, RecordSpec, read_record
from mechid.records.formats import open_table
from mechid.records.undeclared import read_bare

RATE = 1000.0
MILLIS = 500 + np.arange(64)
TORQUE = np.sin(0.3 * np.arange(64.0))
BEGUN = np.datetime64("2024-05-06T07:08:09")


def write_parquet(path, time, name="time"):
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table({name: pa.array(time), "torque": TORQUE}), path)


def write_npy(path, time, name="time"):
    kind = [(name, time.dtype), ("torque", float)]
    np.save(path, np.rec.fromarrays([time, TORQUE], dtype=kind).view(np.ndarray))


def write_npz(path, time, name="time"):
    np.savez(path, **{name: time, "torque": TORQUE})


WRITERS = {"run.parquet": write_parquet, "run.npy": write_npy, "run.npz": write_npz}
DURATIONS = {
    "milliseconds": MILLIS.astype("m8[ms]"),
    "microseconds": (1000 * MILLIS).astype("m8[us]"),
    "nanoseconds": (1_000_000 * MILLIS).astype("m8[ns]"),
}


def read(path, **asked):
    return read_record(path, RecordSpec(name="run", path=path.name, **asked))


@pytest.mark.parametrize("unit", DURATIONS)
@pytest.mark.parametrize("file", WRITERS)
def test_durations_are_seconds(file, unit, tmp_path):
    WRITERS[file](tmp_path / file, DURATIONS[unit])
    record = read(tmp_path / file)
    assert (record.time_start_s, record.sample_rate_hz) == (pytest.approx(0.5), RATE)
    np.testing.assert_array_equal(record.channel("torque").data, TORQUE)
    (looked_at,) = read_bare(tmp_path / file)
    assert looked_at.sample_rate_hz == RATE


@pytest.mark.parametrize("file", WRITERS)
def test_a_unit_in_the_name_is_not_that_of_a_duration(file, tmp_path):
    """Truth: a duration has its unit in itself; by the name `time_ms` these would last a thousandth."""
    WRITERS[file](tmp_path / file, DURATIONS["microseconds"], "time_ms")
    assert read(tmp_path / file).sample_rate_hz == RATE
    named = read(tmp_path / file, time=ChannelSpec(quantity="time", column="time_ms"))
    assert named.sample_rate_hz == RATE


@pytest.mark.parametrize("file", WRITERS)
def test_dates_are_seconds_since_the_first(file, tmp_path):
    WRITERS[file](tmp_path / file, BEGUN + DURATIONS["milliseconds"], "time")
    record = read(tmp_path / file)
    assert (record.time_start_s, record.sample_rate_hz) == (0.0, RATE)


@pytest.mark.parametrize("file", WRITERS)
def test_a_missing_time_is_refused(file, tmp_path):
    time = DURATIONS["milliseconds"].copy()
    time[9] = np.timedelta64("NaT")
    WRITERS[file](tmp_path / file, time)
    with pytest.raises(RecordError, match='column "time": nan is not a finite number'):
        read(tmp_path / file)


def test_a_window_reads_the_durations_in_it(tmp_path):
    from mechid.records import Conditioning

    for file, write in WRITERS.items():
        write(tmp_path / file, DURATIONS["milliseconds"])
        record = read(tmp_path / file, conditioning=Conditioning(window_s=(0.51, 0.54)))
        assert (record.time_start_s, record.samples) == (pytest.approx(0.51), 31)


@pytest.mark.parametrize("unit", ["M", "Y"])
def test_months_have_no_length(unit, tmp_path):
    write_npz(tmp_path / "run.npz", MILLIS.astype(f"m8[{unit}]"))
    faults = {column.name: column.fault for column in open_table(tmp_path / "run.npz", "run.npz").columns}
    assert "times in units that have no length in seconds" in faults["time"]
    assert faults["torque"] is None


def test_durations_are_no_torque(tmp_path):
    write_npz(tmp_path / "run.npz", DURATIONS["milliseconds"], "torque_of_it")
    torque = ChannelSpec(quantity="torque", column="torque_of_it")
    with pytest.raises(RecordError, match='unit "s" does not measure torque'):
        read(tmp_path / "run.npz", channels=(torque,), sample_rate_hz=RATE)
