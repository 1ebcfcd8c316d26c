"""MATLAB and HDF5 files with bytes changed: on some SciPy and HDF5 crash or hang. Truth: one line, whatever they do."""

import os

import numpy as np
import pytest

from instrument_files import write_hdf5, write_mat5, write_mat5_plain
from mechid.errors import RecordError
from mechid.reading import process
from mechid.reading.process import UnreadableError
from mechid.records import ChannelSpec, RecordSpec, open_table, read_record

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="limits of the system")
CRASHED = {
    "an array's dimensions and kind": [(401, 202), (264, 21)],
    "two fields": [(1400, 225), (1650, 117)],
    "three fields": [(941, 75), (771, 163), (1401, 216)],
}
"""Places and bytes on which SciPy 1.17 ends in a segmentation fault, in the file of `write_mat5_plain`."""
HUNG = {"mat": [(166, 205)], "h5": [(2096, 41)]}
"""On which SciPy 1.17, and HDF5 2.0, come to no end."""


def damaged(path, write, changes):
    write(path)
    content = bytearray(path.read_bytes())
    for place, byte in changes:
        content[place] = byte
    path.write_bytes(content)


def refusal(path):
    """Read every column; return the error, which is one line that names the file, None where there was none."""
    try:
        table = open_table(path, path.name)
        for number, column in enumerate(table.columns):
            if not column.fault:
                table.read([number])
    except RecordError as error:
        assert str(error).startswith(path.name)  # noqa: PT017
        assert "\n" not in str(error)  # noqa: PT017
        return error
    return None


@pytest.mark.parametrize("changes", CRASHED.values(), ids=CRASHED)
def test_a_file_that_crashes_the_reader_is_one_line(changes, tmp_path):
    path = tmp_path / "run.mat"
    damaged(path, write_mat5_plain, changes)
    error = refusal(path)
    if isinstance(error, RecordError) and isinstance(error.__cause__, UnreadableError):
        assert "run.mat: is cut off, damaged, or not a " in str(error)
        assert "the library that reads it crashed" in str(error)
        assert str(error).endswith("; write or copy it anew")
    write_mat5(path)
    assert refusal(path) is None


@pytest.mark.parametrize(("suffix", "write"), [("mat", write_mat5_plain), ("h5", write_hdf5)])
def test_a_file_that_hangs_the_reader_is_one_line(suffix, write, tmp_path, monkeypatch):
    monkeypatch.setattr(process, "TIMEOUT_S", 1.0)
    path = tmp_path / f"run.{suffix}"
    damaged(path, write, HUNG[suffix])
    error = refusal(path)
    if isinstance(error, RecordError) and isinstance(error.__cause__, UnreadableError):
        assert "reading it did not finish within 1 s" in str(error)
    write(path)
    assert refusal(path) is None


def test_another_file_under_the_same_name_is_read_anew(tmp_path):
    for scale in (1.0, 2.0):
        np.savez(tmp_path / "run.npz", torque=scale * np.sin(np.arange(64.0)))
        os.utime(tmp_path / "run.npz", (scale, scale))
        torque = ChannelSpec(quantity="torque", column="torque")
        spec = RecordSpec(name="run", path="run.npz", channels=(torque,), sample_rate_hz=1.0)
        found = read_record(tmp_path / "run.npz", spec).channel("torque").data
        np.testing.assert_array_equal(found, scale * np.sin(np.arange(64.0)))
