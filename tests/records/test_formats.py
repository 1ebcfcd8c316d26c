"""Every format. Truth: the arrays that a file was written from; whatever is wrong is one line."""

import sys

import numpy as np
import pytest
import scipy.io

from instrument_files import CURRENT, FORMATS, RATE, TIME, TORQUE, data_set_58, write_tdms
from mechid.errors import RecordError
from mechid.records import READERS, ChannelSpec, Conditioning, open_table
from records_read import read, refused, torque

CUTS, DAMAGES = 50, 20
BINARY = [name for name in FORMATS if name != "csv"]
FROM_TEXT = {"uff 58": 2e-13, "uff 58, uneven": 1e-5, "csv": 1e-9}
"""Relative accuracy of numbers that the file holds as text; its uneven abscissa has six digits."""


@pytest.fixture(params=FORMATS)
def written(request, tmp_path):
    """Return the name of a format and a file of it."""
    one = FORMATS[request.param]
    one.write(tmp_path / one.name)
    return request.param, tmp_path / one.name


def test_the_arrays_come_back_in_si(written):
    name, path = written
    record = read(path, torque(FORMATS[name].torque), ChannelSpec(quantity="current_phase_a", column="iA"))
    tolerance = FROM_TEXT.get(name, 1e-14)
    np.testing.assert_allclose(record.channel("torque").data, TORQUE, rtol=tolerance, atol=1e-9 * (name in FROM_TEXT))
    np.testing.assert_allclose(record.channel("current_phase_a").data, CURRENT, rtol=tolerance, atol=1e-9)
    assert record.sample_rate_hz == RATE
    assert record.time_start_s == 0.0
    assert record.warnings == ()


def test_a_window_reads_the_same_samples(written):
    """Twin: the whole record, cut."""
    name, path = written
    how = Conditioning(window_s=(0.010, 0.0405))
    record = read(path, torque(FORMATS[name].torque), conditioning=how)
    whole = read(path, torque(FORMATS[name].torque))
    np.testing.assert_array_equal(record.channel("torque").data, whole.channel("torque").data[10:41])
    assert record.time_start_s == pytest.approx(0.010, abs=1e-12)


def test_an_index_selects_the_same_column(written):
    name, path = written
    keys = [column.bare_name for column in open_table(path, path.name).columns]
    by_index = read(path, torque(keys.index("Mz"))).channel("torque")
    np.testing.assert_array_equal(by_index.data, read(path, torque(FORMATS[name].torque)).channel("torque").data)


def test_metadata_are_kept_and_go_to_the_provenance(written):
    name, path = written
    record = read(path, torque(FORMATS[name].torque))
    for key, value in FORMATS[name].metadata.items():
        assert record.metadata[key] == value
        assert record.provenance["metadata"][key] == value


def test_what_a_channel_says_of_itself_is_kept(tmp_path):
    write_tdms(tmp_path / "run.tdms")
    record = read(tmp_path / "run.tdms", torque("Mz"))
    assert record.channel("torque").metadata == {"sensitivity": 2.5}
    assert record.start_time == "2024-05-06T07:08:09.000000"
    assert record.provenance["start_time"] == record.start_time


def test_a_wrong_column_is_refused(written):
    _, path = written
    assert 'did you mean "Mz' in refused(path, torque("Mzz"))
    assert "they go from 0 to" in refused(path, torque(99))


def test_a_unit_of_another_quantity_is_refused(written):
    _, path = written
    message = refused(path, ChannelSpec(quantity="force", column="Mz"))
    assert "does not measure force; expected N or a multiple of it" in message


def test_the_campaigns_unit_must_not_contradict_the_files(written):
    _, path = written
    assert 'its unit contradicts unit = "N*m"' in refused(path, torque("Mz", unit="N*m"))


def test_a_rate_that_the_file_contradicts_is_refused(written):
    name, path = written
    assert "sample_rate_hz = 900 contradicts the" in refused(path, torque(FORMATS[name].torque), sample_rate_hz=900.0)


@pytest.mark.parametrize("name", BINARY)
def test_a_file_cut_anywhere_is_refused_with_one_line(name, tmp_path):
    """Truth: half a file is not the file. A cut in the empty end of a MAT 7.3 or HDF5 file may leave all arrays."""
    one = FORMATS[name]
    path = tmp_path / one.name
    one.write(path)
    whole = path.read_bytes()
    expected = read(path, torque(one.torque)).channel("torque").data
    for end in np.random.default_rng(1).integers(0, len(whole) - 1, CUTS):
        path.write_bytes(whole[:end])
        try:
            found = read(path, torque(one.torque))
        except RecordError as error:
            assert str(error).startswith(one.name)  # noqa: PT017
            assert "\n" not in str(error)  # noqa: PT017
            continue
        np.testing.assert_array_equal(found.channel("torque").data, expected)


@pytest.mark.parametrize("name", BINARY)
def test_a_damaged_file_is_a_record_or_one_line(name, tmp_path):
    one = FORMATS[name]
    path = tmp_path / one.name
    one.write(path)
    whole = bytearray(path.read_bytes())
    rng = np.random.default_rng(2)
    for _ in range(DAMAGES):
        damaged = bytearray(whole)
        for place in rng.integers(0, len(whole), 4):
            damaged[place] = rng.integers(0, 256)
        path.write_bytes(damaged)
        try:
            read(path, torque(one.torque))
        except RecordError as error:
            assert str(error).startswith(one.name)  # noqa: PT017
            assert "\n" not in str(error)  # noqa: PT017


@pytest.mark.parametrize("name", BINARY)
def test_a_file_of_another_format_is_refused(name, tmp_path):
    path = tmp_path / FORMATS[name].name
    path.write_text("time_s,torque_Nm\n0.0,1.0\n")
    refused(path, torque("Mz"))


@pytest.mark.parametrize(
    ("name", "module", "package"),
    [
        ("hdf5", "h5py", "h5py"),
        ("mat 7.3", "h5py", "h5py"),
        ("tdms", "nptdms", "npTDMS"),
        ("uff 58", "pyuff", "pyuff"),
        ("parquet", "pyarrow.parquet", "pyarrow"),
    ],
)
def test_a_missing_library_is_said_with_its_remedy(monkeypatch, tmp_path, name, module, package):
    path = tmp_path / FORMATS[name].name
    FORMATS[name].write(path)
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(RecordError) as caught:
        READERS[path.suffix](path, path.name)  # in this process, which lacks it
    message = str(caught.value)
    assert f"reading it needs {package}, which is not installed" in message
    assert message.endswith('pip install "mechid[formats]"')


def test_the_only_torque_needs_no_channels(tmp_path):
    np.savez(tmp_path / "run.npz", t=TIME, torque_mNm=TORQUE, x=CURRENT)
    np.testing.assert_allclose(read(tmp_path / "run.npz").channel("torque").data, 1e-3 * TORQUE)
    np.savez(tmp_path / "two.npz", t=TIME, a=TORQUE, b=CURRENT)
    assert 'which column is it? name it in channels; the file has "t", "a", "b"' in refused(tmp_path / "two.npz")


def test_integers_without_a_unit_are_taken_and_said(tmp_path):
    counts = np.arange(64) % 7
    np.savez(tmp_path / "run.npz", t=TIME, x=counts)
    record = read(tmp_path / "run.npz", torque("x"))
    np.testing.assert_array_equal(record.channel("torque").data, counts)
    assert record.warnings == (
        'run.npz: column "x": integers without a unit, read in N*m; are they raw counts? then give unit and gain',
    )
    assert read(tmp_path / "run.npz", torque("x", unit="mNm", gain=0.25)).warnings == ()


def test_two_columns_that_may_be_the_time_are_asked_about(tmp_path):
    np.savez(tmp_path / "run.npz", time_a=TIME, time_b=2.0 * TIME, torque=TORQUE)
    message = refused(tmp_path / "run.npz", torque("torque"))
    assert message.endswith('2 columns may be the time; name it, as time = { column = ... }: "time_a", "time_b"')
    named = read(tmp_path / "run.npz", torque("torque"), time=ChannelSpec(quantity="time", column="time_b"))
    assert named.sample_rate_hz == RATE / 2.0


def test_two_rates_in_one_file_make_two_records(tmp_path):
    from nptdms import ChannelObject, TdmsWriter

    path = tmp_path / "run.tdms"
    with TdmsWriter(path) as file:
        fast = ChannelObject("g", "fast", TORQUE, {"wf_increment": 1e-3})
        slow = ChannelObject("g", "slow", CURRENT, {"wf_increment": 1e-2})
        file.write_segment([fast, slow])
    current = ChannelSpec(quantity="current_phase_a", column="slow")
    message = refused(path, torque("fast"), current)
    assert '"g/fast" and column "g/slow" have not the same clock (1000 Hz from 0 s; 100 Hz from 0 s)' in message
    assert [read(path, torque(name)).sample_rate_hz for name in ("fast", "slow")] == [1000.0, 100.0]


def test_channels_that_start_at_different_times_are_refused(tmp_path):
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(tmp_path / "run.tdms") as file:
        file.write_segment(
            [
                ChannelObject("g", name, TORQUE, {"wf_increment": 1e-3, "wf_start_time": np.datetime64(start)})
                for name, start in (("a", "2024-05-06T07:08:09"), ("b", "2024-05-06T07:08:10"))
            ]
        )
    current = ChannelSpec(quantity="current_phase_a", column="b")
    assert "have not the same clock" in refused(tmp_path / "run.tdms", torque("a"), current)


def test_a_recording_that_was_broken_off_is_refused(tmp_path):
    """Truth: a second segment of the same channels, of which the last 100 bytes are missing."""
    from nptdms import ChannelObject, TdmsWriter

    path = tmp_path / "run.tdms"
    with TdmsWriter(path) as file:
        for part in (TORQUE, CURRENT):
            file.write_segment([ChannelObject("g", "a", part, {"wf_increment": 1e-3})])
    assert read(path, torque("a")).samples == 128
    path.write_bytes(path.read_bytes()[:-100])
    assert "the recording was cut off" in refused(path, torque("a"))


def test_an_unknown_scaling_is_refused_not_left_out(tmp_path):
    from nptdms import ChannelObject, TdmsWriter

    scaling = {"NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Reciprocal", "wf_increment": 1e-3}
    with TdmsWriter(tmp_path / "run.tdms") as file:
        file.write_segment([ChannelObject("g", "a", TORQUE, scaling)])
    assert 'its scaling "Reciprocal" is unknown' in refused(tmp_path / "run.tdms", torque("a"))


UNIVERSAL = {
    "frequency response": ({"func_type": 4}, "no time history but a frequency response function"),
    "complex": ({"data": TORQUE + 1j}, "complex numbers"),
    "over frequency": ({"abscissa_spec_data_type": 18}, "no time history"),
    "abscissa in Hz": ({"abscissa_axis_units_lab": "Hz"}, 'its abscissa: unit "Hz" does not measure time'),
    "abscissa that stands": ({"abscissa_inc": 0.0, "x": np.zeros(64)}, "its abscissa advances by 0 s"),
}


@pytest.mark.parametrize("name", UNIVERSAL)
def test_a_data_set_that_is_no_time_history_is_refused(name, tmp_path):
    import pyuff

    changes, reason = UNIVERSAL[name]
    path = tmp_path / "run.uff"
    changes = dict(changes)
    pyuff.UFF(str(path)).write_sets([data_set_58("Mz", changes.pop("data", TORQUE), "Nm", **changes)], mode="overwrite")
    assert reason in refused(path, torque("Mz"))


def test_numbers_in_units_of_data_set_164_are_refused_until_the_campaign_names_theirs(tmp_path):
    import pyuff

    path = tmp_path / "run.uff"
    units = pyuff.prepare_164(
        units_code=5, units_description="mm", temp_mode=1, length=1e3, force=1e3, temp=1.0, temp_offset=0.0
    )
    pyuff.UFF(str(path)).write_sets([units, data_set_58("Mz", TORQUE, "NONE")], mode="overwrite")
    assert 'unknown unit "that of data set 164" for torque' in refused(path, torque("Mz"))
    record = read(path, torque("Mz", unit="mN*m"))
    np.testing.assert_allclose(record.channel("torque").data, 1e-3 * TORQUE)
    assert "as the campaign says" in record.warnings[0]


def test_dates_are_seconds_since_the_first(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    stamps = np.datetime64("2024-05-06T07:08:09", "ns") + np.arange(64) * np.timedelta64(1_000_000, "ns")
    pq.write_table(pa.table({"time": stamps, "torque_Nm": TORQUE}), tmp_path / "run.parquet")
    record = read(tmp_path / "run.parquet")
    assert (record.time_start_s, record.sample_rate_hz) == (0.0, 1000.0)


def test_empty_cells_of_parquet_are_missing(tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    values = [None if k == 5 else value for k, value in enumerate(TORQUE.tolist())]
    pq.write_table(pa.table({"time": TIME, "torque": values}), tmp_path / "run.parquet")
    assert "sample 5" in refused(tmp_path / "run.parquet")


def test_fields_of_structs_and_cells_have_paths(tmp_path):
    runs = np.empty(2, dtype=[("torque", object), ("label", object)])
    runs[0], runs[1] = (TORQUE, "a"), (CURRENT, "b")
    cells = np.empty(2, dtype=object)
    cells[:] = [TIME, 2.0 * TIME]
    scipy.io.savemat(tmp_path / "run.mat", {"runs": runs, "t": cells})
    table = open_table(tmp_path / "run.mat", "run.mat")
    assert [column.key for column in table.columns] == ["runs/torque/0", "runs/torque/1", "t/0", "t/1"]
    np.testing.assert_array_equal(table.read([1])[0], CURRENT)
    assert table.metadata["runs/label/1"] == "b"
