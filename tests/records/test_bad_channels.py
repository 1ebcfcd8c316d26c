"""Channels that cannot be what they are asked for, in every format that can hold them: one line each, no wrong number.

Truth: the arrays that the test writes.
"""

import numpy as np
import pytest
import scipy.io

from instrument_files import RATE, TIME, TORQUE
from mechid.errors import RecordError
from mechid.records import ChannelSpec, Conditioning
from records_read import read


def write_npz(path, arrays):
    np.savez(path, **arrays)


def write_mat5(path, arrays):
    scipy.io.savemat(path, arrays)


def write_hdf5(path, arrays):
    import h5py

    with h5py.File(path, "w") as file:
        for name, values in arrays.items():
            file[name] = values


def write_tdms(path, arrays):
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(path) as file:
        file.write_segment([ChannelObject("run", name, values) for name, values in arrays.items()])


def write_parquet(path, arrays):
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = {name: values.tolist() if values.ndim > 1 else values for name, values in arrays.items()}
    pq.write_table(pa.table(columns), path)


def write_csv(path, arrays):
    rows = zip(*(values.tolist() for values in arrays.values()), strict=True)
    path.write_text(",".join(arrays) + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in rows))


WRITERS = {
    "run.npz": write_npz,
    "run.mat": write_mat5,
    "run.h5": write_hdf5,
    "run.tdms": write_tdms,
    "run.parquet": write_parquet,
    "run.csv": write_csv,
}
BURST = np.isin(np.arange(64), [*range(9, 14), *range(40, 47)])
BACK = np.concatenate([TIME[:30], TIME[:34]])
BAD = {
    "complex": ({"time": TIME, "x": TORQUE + 1j * TORQUE}, ("complex numbers",)),
    "a matrix": ({"time": TIME, "x": np.outer(TORQUE, TORQUE)}, ("a matrix is no channel", "no numbers", "no such")),
    "three dimensions": ({"time": TIME, "x": np.ones((64, 3, 2))}, ("a channel has one dimension", "no numbers")),
    "bursts that are no number": (
        {"time": TIME, "x": np.where(BURST, np.nan, TORQUE)},
        ("nan is not a finite number",),
    ),
    "infinity": ({"time": TIME, "x": np.where(BURST, np.inf, TORQUE)}, ("inf is not a finite number",)),
    "a clock that goes back": ({"time": BACK, "x": TORQUE}, ("the clock goes back, from 0.029 s to 0 s",)),
    "a clock that is no number": (
        {"time": np.where(BURST, np.nan, TIME), "x": TORQUE},
        ("nan is not a finite number",),
    ),
    "another rate": (
        {"time": TIME, "x": TORQUE[::2]},
        ('"time" has 64 samples', "no time column", "64 samples, column"),
    ),
}
HELD_BY = {
    "run.tdms": set(BAD) - {"a matrix", "three dimensions"},
    "run.parquet": set(BAD) - {"complex", "another rate"},
    "run.csv": set(BAD) - {"complex", "a matrix", "three dimensions", "another rate"},
}
CASES = [(name, kind) for name in WRITERS for kind in BAD if kind in HELD_BY.get(name, BAD)]


@pytest.mark.parametrize(("name", "kind"), CASES)
def test_what_is_no_channel_is_refused_with_one_line(tmp_path, name, kind):
    arrays, reasons = BAD[kind]
    WRITERS[name](tmp_path / name, arrays)
    with pytest.raises(RecordError) as caught:
        read(tmp_path / name, ChannelSpec(quantity="torque", column="x"))
    message = str(caught.value)
    assert message.startswith(f"{name}:")
    assert "\n" not in message
    assert any(reason in message for reason in reasons), message
    assert caught.value.exit_code == 4


@pytest.mark.parametrize("name", WRITERS)
def test_whole_numbers_come_as_they_are_with_a_word(tmp_path, name):
    counts = (7 * np.arange(64)) % 251 - 100
    WRITERS[name](tmp_path / name, {"time": TIME, "x": counts.astype(np.int16)})
    record = read(tmp_path / name, ChannelSpec(quantity="torque", column="x"))
    np.testing.assert_array_equal(record.channel("torque").data, counts)
    if name != "run.csv":  # a text does not say how its numbers were stored
        assert "are they raw counts?" in record.warnings[0]


@pytest.mark.parametrize("name", WRITERS)
def test_bursts_are_bridged_where_that_is_asked_for_and_no_longer(tmp_path, name):
    WRITERS[name](tmp_path / name, {"time": TIME, "x": np.where(BURST, np.nan, TORQUE)})
    asked = ChannelSpec(quantity="torque", column="x")
    found = read(tmp_path / name, asked, conditioning=Conditioning(max_gap_s=7.5 / RATE))
    expected = np.interp(TIME, TIME[~BURST], TORQUE[~BURST])
    np.testing.assert_allclose(found.channel("torque").data, expected, rtol=1e-12, atol=1e-15)
    with pytest.raises(RecordError, match="7 samples"):
        read(tmp_path / name, asked, conditioning=Conditioning(max_gap_s=5.5 / RATE))
