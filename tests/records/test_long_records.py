"""A record longer than memory. Truth: the same file read whole; and the memory that a process of its own takes."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from little_memory import IN_MEMORY, little_memory  # noqa: F401
from mechid.errors import RecordError
from mechid.records import ChannelSpec, Conditioning, RecordSpec, TimeStamps, open_table, read_record

RATE, SAMPLES = 1000.0, 4001
TIME = np.arange(SAMPLES) / RATE
TORQUE = np.sin(0.03 * np.arange(SAMPLES)) + 0.2
ANGLE = np.cos(0.01 * np.arange(SAMPLES))
GAPS = [5, 698, 699, 700, 701, 702, 2998, 2999, 3000, 3333, 3334]
"""Missing samples: within a block of 333, over the ends of some, and where a series goes to a file."""


def write_csv(path, torque):
    rows = "".join(
        f"{t:.3f};{m!r};{a!r}\n" for t, m, a in zip(TIME.tolist(), torque.tolist(), ANGLE.tolist(), strict=True)
    )
    path.write_text("time_s;torque_Nm;angle_rad\n" + rows.replace(".", ",") + "\n")


def write_hdf5(path, torque):
    import h5py

    with h5py.File(path, "w") as file:
        for name, values in (("time", TIME), ("torque_Nm", torque), ("angle_rad", ANGLE)):
            file.create_dataset(name, data=values, chunks=(500,), compression="gzip")


def write_matlab73(path, torque):
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in (("time", TIME), ("torque_Nm", torque), ("angle_rad", ANGLE)):
            file.create_dataset(name, data=values[None], chunks=(1, 500)).attrs["MATLAB_class"] = np.bytes_("double")
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")


def write_tdms(path, torque):
    import nptdms

    with nptdms.TdmsWriter(path) as file:
        for start in range(0, SAMPLES, 900):
            part = slice(start, start + 900)
            columns = (("time", TIME), ("torque_Nm", torque), ("angle_rad", ANGLE))
            file.write_segment([nptdms.ChannelObject("run", name, values[part]) for name, values in columns])


def write_parquet(path, torque, rows=10_000):
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = {"time": TIME, "torque_Nm": torque, "angle_rad": ANGLE}
    pq.write_table(pa.table(columns), path, row_group_size=rows)


def write_npy(path, torque):
    table = np.rec.fromarrays([TIME, torque, ANGLE], names=["time", "torque_Nm", "angle_rad"])
    np.save(path, table)


def write_npz(path, torque):
    np.savez(path, time=TIME, torque_Nm=torque, angle_rad=ANGLE)


FORMATS = {
    "csv": ("run.csv", write_csv),
    "hdf5": ("run.h5", write_hdf5),
    "mat 7.3": ("run.mat", write_matlab73),
    "tdms": ("run.tdms", write_tdms),
    "parquet": ("run.parquet", write_parquet),
    "parquet, short row groups": ("run.parquet", lambda path, torque: write_parquet(path, torque, 450)),
    "npy": ("run.npy", write_npy),
    "npz": ("run.npz", write_npz),
}
CONDITIONED = {
    "as it is": Conditioning(),
    "window": Conditioning(window_s=(0.35, 3.21)),
    "quiet": Conditioning(quiet_s={"torque": ((0.1, 0.9), (2.0, 2.5))}, window_s=(0.3, 3.9)),
    "cumulated": Conditioning(cumulate=("rotor_angle",)),
    "limits": Conditioning(limits={"torque": (-2.39, 1.55)}, max_gap_s=0.3),
    "decimated": Conditioning(decimate=3, window_s=(0.0, 3.9)),
    "nearest clock": Conditioning(time_stamps=TimeStamps.REGULAR),
}


CHANNELS = (
    ChannelSpec(quantity="torque", column="torque_Nm", gain=-2.0),
    ChannelSpec(quantity="rotor_angle", column="angle_rad"),
)
SPEC = RecordSpec(name="run", path="run", channels=CHANNELS)


def read(path, how=None):
    return read_record(path, replace(SPEC, path=path.name, conditioning=how or Conditioning()))


def same(long, short, rtol=0.0):
    assert long.samples == short.samples
    assert long.sample_rate_hz == pytest.approx(short.sample_rate_hz, rel=rtol, abs=0.0)
    assert long.time_start_s == pytest.approx(short.time_start_s, rel=rtol, abs=rtol)
    assert long.warnings == short.warnings
    for done, expected in zip(long.treatments, short.treatments, strict=True):
        assert done["step"] == expected["step"]
        if done["step"] != "time_stamps":  # which tells a jitter that is rounding
            assert done["text"] == expected["text"]
    for one, other in zip(long.channels, short.channels, strict=True):
        assert not isinstance(one.data, np.ndarray) or one.data.size <= IN_MEMORY
        assert isinstance(other.data, np.ndarray)
        np.testing.assert_allclose(one.data[:], other.data, rtol=rtol, atol=rtol)
        np.testing.assert_array_equal(one.bridged, other.bridged)


@pytest.mark.parametrize("name", FORMATS)
def test_by_blocks_it_is_the_record_that_is_read_whole(name, tmp_path, little_memory, monkeypatch):  # noqa: F811
    file, write = FORMATS[name]
    write(tmp_path / file, TORQUE)
    long = read(tmp_path / file)
    monkeypatch.undo()
    same(long, read(tmp_path / file))


@pytest.mark.parametrize("name", CONDITIONED)
def test_conditioning_by_blocks_is_that_of_the_whole(name, tmp_path, little_memory, monkeypatch):  # noqa: F811
    write_hdf5(tmp_path / "run.h5", TORQUE)
    long = read(tmp_path / "run.h5", CONDITIONED[name])
    monkeypatch.undo()
    same(long, read(tmp_path / "run.h5", CONDITIONED[name]), rtol=1e-12)


@pytest.mark.parametrize("name", ["csv", "hdf5"])
@pytest.mark.parametrize("decimate", [1, 3])
def test_gaps_over_the_ends_of_blocks_are_bridged(name, decimate, tmp_path, little_memory, monkeypatch):  # noqa: F811
    torque = TORQUE.copy()
    torque[GAPS] = np.nan
    file, write = FORMATS[name]
    write(tmp_path / file, torque)
    how = Conditioning(max_gap_s=0.006, decimate=decimate)
    long = read(tmp_path / file, how)
    monkeypatch.undo()
    same(long, read(tmp_path / file, how), rtol=1e-12 if decimate > 1 else 0.0)


@pytest.mark.parametrize("rate_hz", [None, RATE])
def test_late_stamps_with_losses_are_placed_by_blocks(rate_hz, tmp_path, little_memory, monkeypatch):  # noqa: F811
    """Truth: places drawn at random, one in twenty lost, the clock found from memory."""
    rng = np.random.default_rng(8)
    kept = np.flatnonzero(rng.random(SAMPLES) > 0.05)
    kept = kept[(kept < 660) | (kept > 668)]  # missing where a block ends
    stamps = (kept + rng.uniform(-0.3, 0.3, kept.size)) / RATE
    np.savez(tmp_path / "run.npz", time=stamps, torque_Nm=TORQUE[kept], angle_rad=ANGLE[kept])
    how = Conditioning(time_stamps=TimeStamps.REGULAR, max_gap_s=0.02)
    spec = replace(SPEC, sample_rate_hz=rate_hz, conditioning=how)
    long = read_record(tmp_path / "run.npz", spec)
    missing = np.setdiff1d(np.arange(kept[0], kept[-1] + 1), kept) - kept[0]
    np.testing.assert_array_equal(long.channels[0].bridged, missing)
    monkeypatch.undo()
    same(long, read_record(tmp_path / "run.npz", spec), rtol=1e-9)


@pytest.mark.parametrize("name", ["csv", "hdf5", "parquet", "npy"])
def test_what_is_wrong_is_said_as_of_the_whole(name, tmp_path, little_memory, monkeypatch):  # noqa: F811
    torque = TORQUE.copy()
    torque[3500] = np.nan
    file, write = FORMATS[name]
    write(tmp_path / file, torque)
    said = []
    for _ in range(2):
        with pytest.raises(RecordError) as caught:
            read(tmp_path / file)
        said.append(str(caught.value))
        monkeypatch.undo()
    assert said[0] == said[1]
    assert ("line 3502" if name == "csv" else "sample 3500") in said[0]


def test_a_line_of_text_that_is_no_number_is_found_in_a_later_block(tmp_path, little_memory):  # noqa: F811
    write_csv(tmp_path / "run.csv", TORQUE)
    lines = (tmp_path / "run.csv").read_text().splitlines()
    lines[3002] = lines[3002].replace(";", ";x", 1)
    (tmp_path / "run.csv").write_text("\n".join(lines))
    with pytest.raises(RecordError, match=r"line 3003.*is not a number"):
        read(tmp_path / "run.csv")


@pytest.mark.parametrize("name", FORMATS)
def test_the_rows_of_a_table_come_in_blocks(name, tmp_path, little_memory):  # noqa: F811
    """Truth: the arrays that were written; where a format is sliced, in more than one piece."""
    file, write = FORMATS[name]
    write(tmp_path / file, TORQUE)
    table = open_table(tmp_path / file, file)
    wanted = [next(k for k, column in enumerate(table.columns) if column.name.startswith("torque"))]
    parts = [block[0] for block in table.blocks(wanted, slice(100, 3900))]
    np.testing.assert_array_equal(np.concatenate(parts), TORQUE[100:3900])
    assert (len(parts) > 1) == table.is_sliced
    np.testing.assert_array_equal(table.read(wanted, slice(250, 251))[0], TORQUE[250:251])


READ = """
import sys
from dataclasses import replace
from pathlib import Path
from mechid.records import ChannelSpec, RecordSpec, read_record
from mechid.signal import noise_floor
from mechid.signal.moments import standard_deviation

def peak():
    status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
    return int(status["VmHWM"].split()[0]) * 1024

path = Path(sys.argv[1])
channels = (ChannelSpec(quantity="torque", column="torque" if path.suffix == ".h5" else 0),)
spec = RecordSpec(name="run", path=path.name, sample_rate_hz=1e4, channels=channels)
small = read_record(path.with_stem("short"), spec)
noise_floor(small.channels[0].data, 1e4)
before = peak()
record = read_record(path, spec)
data = record.channels[0].data
print(record.samples, peak() - before, standard_deviation(data), noise_floor(data, 1e4), peak() - before)
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads the peak from /proc")
@pytest.mark.parametrize("suffix", ["h5", "npy"])
def test_a_long_record_takes_a_tenth_of_its_length_in_memory(suffix, tmp_path, monkeypatch):
    """Truth: 12 million samples are 96 MB; a process that has read a short file before takes 40 MB more for them."""
    import h5py

    monkeypatch.setenv("MECHID_CACHE", str(tmp_path / "cache"))
    some = np.random.default_rng(3).standard_normal(1_000_000)
    for stem, times in (("short", 1), ("run", 12)):
        values = np.tile(some, times)
        if suffix == "npy":
            np.save(tmp_path / f"{stem}.npy", values)
        else:
            with h5py.File(tmp_path / f"{stem}.h5", "w") as file:
                file.create_dataset("torque", data=values, chunks=(2**16,))
    command = [sys.executable, "-c", READ, str(tmp_path / f"run.{suffix}")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    samples, to_read, sigma, floor, in_all = map(float, done.stdout.split())
    assert samples == 12_000_000
    assert sigma == pytest.approx(float(some.std()), rel=1e-9)
    assert floor == pytest.approx(1.0, rel=0.01)
    assert to_read < 25e6
    assert in_all < 40e6


def test_check_says_that_a_record_is_long_and_how_long_it_took(tmp_path, little_memory):  # noqa: F811
    from mechid.checks.numbers import check_numbers
    from synthetic import COMMANDS, campaign, record, truth

    write_hdf5(tmp_path / "run.h5", TORQUE)
    data = read(tmp_path / "run.h5")
    assert 0.0 < data.reading_s < 60.0
    entry = record("run", TORQUE, COMMANDS["full_46"], rate_hz=RATE)
    lines = check_numbers(campaign(truth(), replace(entry, data=data)))["records"][0]["lines"]
    assert f"a long record: read block by block in {data.reading_s:.3g} s, kept in a temporary file" in "\n".join(lines)
