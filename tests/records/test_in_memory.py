"""Records from arrays, data frames and data sets. Truth: the arrays given, and the rules of files."""

import numpy as np
import pytest

from mechid.errors import RecordError
from mechid.records import ChannelSpec, Conditioning, RecordSpec
from mechid.records.in_memory import columns_of, record_of
from packed_files import COUNTS, RATE, TIME, write_hdf5
from records_read import read, torque

MILLIS = 500 + np.arange(64)
TORQUE = np.sin(0.3 * np.arange(64.0))


def test_durations_in_memory_are_seconds():
    import pandas as pd

    frame = pd.DataFrame({"torque": TORQUE}, index=pd.to_timedelta(MILLIS, unit="ms"))
    samples = {
        "an index": frame,
        "a column": frame.reset_index(names="time"),
        "a mapping": {"time": (1000 * MILLIS).astype("m8[us]"), "torque": TORQUE},
    }
    spec = RecordSpec(name="a", path="a", channels=(ChannelSpec(quantity="torque", column="torque"),))
    for found in samples.values():
        record = record_of(columns_of(found, "a"), spec)
        assert (record.time_start_s, record.sample_rate_hz) == (pytest.approx(0.5), 1000.0)


def xarray_of(attributes, time=TIME, **of_time):
    import xarray as xr

    counts = np.where(np.arange(200) == 3, -9999, COUNTS) if "_FillValue" in attributes else COUNTS
    return xr.Dataset(
        {"torque": ("time", counts, {"units": "N m", **attributes})}, coords={"time": ("time", time, of_time)}
    )


def in_memory(samples):
    spec = RecordSpec(name="a", path="a", channels=(torque("torque"),), conditioning=Conditioning(max_gap_s=1.0))
    return record_of(columns_of(samples, "a"), spec)


def test_a_data_set_in_memory_obeys_the_same_rules():
    import xarray as xr

    packed_set = xarray_of({"scale_factor": 1e-4, "add_offset": 0.1, "_FillValue": np.int16(-9999)})
    decoded = xr.decode_cf(packed_set)
    for samples in (packed_set, decoded):
        record = in_memory(samples)
        kept = np.flatnonzero(np.arange(200) != 3)
        np.testing.assert_allclose(record.channel("torque").data[kept], (1e-4 * COUNTS + 0.1)[kept], rtol=1e-6)
    with pytest.raises(RecordError, match="the file states gain = 4"):
        in_memory(xarray_of({"gain": 4.0}))


def test_attributes_of_a_data_frame_obey_the_same_rules():
    import pandas as pd

    series = pd.Series(COUNTS, index=TIME, name="torque")
    series.attrs = {"units": "mN m", "scale_factor": 0.1}
    alone = series.to_frame()
    alone.attrs = dict(series.attrs)
    several = pd.DataFrame({"torque": COUNTS, "angle": TIME}, index=TIME)
    several.attrs = {"torque": dict(series.attrs), "gain": 7.0}
    for samples in (series, alone, several):
        np.testing.assert_allclose(in_memory(samples).channel("torque").data, 1e-4 * COUNTS)
    series.attrs["gain"] = 7.0
    with pytest.raises(RecordError, match="the file states gain = 7"):
        in_memory(series)


def test_a_time_coordinate_has_its_unit():
    for samples in (
        xarray_of({}, 1e3 * TIME, units="ms"),
        xarray_of({}, TIME, units="seconds since 2024-05-06 00:00:00"),
    ):
        record = in_memory(samples)
        assert record.sample_rate_hz == pytest.approx(RATE)


def test_a_time_that_counts_from_a_date_is_read(tmp_path):
    import h5py

    path = tmp_path / "run.h5"
    write_hdf5(path, 1.0 * COUNTS, units="N m")
    with h5py.File(path, "a") as file:
        file["run/time"].attrs["units"] = "seconds since 2024-05-06 07:08:09"
    assert read(path, torque("torque")).sample_rate_hz == pytest.approx(RATE)
