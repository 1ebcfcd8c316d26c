"""Files larger than the disk or memory: refused with what to do, or read in part."""

import numpy as np
import pytest

from instrument_files import FORMATS, RATE, TORQUE
from mechid.records import Conditioning
from records_read import read, refused, torque


def test_a_file_larger_than_the_disk_is_refused_and_a_part_of_it_read(tmp_path):
    """2^40 samples that were never written take no room in an HDF5 file."""
    import h5py

    with h5py.File(tmp_path / "run.h5", "w") as file:
        huge = file.create_dataset("torque", (2**40,), "f8", chunks=(2**14,))
        huge[5000:5064] = TORQUE
    message = refused(tmp_path / "run.h5", sample_rate_hz=RATE)
    assert "GiB of disk while they are read" in message
    assert message.endswith("read a part with window_s")
    how = Conditioning(window_s=(5.0, 5.063))
    np.testing.assert_array_equal(
        read(tmp_path / "run.h5", sample_rate_hz=RATE, conditioning=how).channel("torque").data, TORQUE
    )


def test_a_text_file_whose_numbers_the_disk_cannot_hold_is_refused(tmp_path):
    """Truth: 8 TiB that were never written take no room on the disk; their numbers would."""
    path = tmp_path / FORMATS["csv"].name
    FORMATS["csv"].write(path)
    with path.open("r+b") as file:
        try:
            file.truncate(2**43)
        except OSError:
            pytest.skip("this file system has no files of 8 TiB")
    assert "GiB of disk while they are read" in refused(path, torque(FORMATS["csv"].torque))


@pytest.mark.parametrize("name", ["mat 5", "uff 58", "uff 58b"])
def test_a_file_larger_than_memory_that_is_read_whole_is_refused(name, tmp_path):
    """Truth: 8 TiB that were never written take no room on the disk."""
    path = tmp_path / FORMATS[name].name
    FORMATS[name].write(path)
    with path.open("r+b") as file:
        try:
            file.truncate(2**43)
        except OSError:
            pytest.skip("this file system has no files of 8 TiB")
    message = refused(path, torque(FORMATS[name].torque))
    assert "8.19e+03 GiB, and reading it may take" in message
    assert "is read whole: save it as HDF5 or Parquet" in message


def test_a_mapped_file_larger_than_the_disk_is_refused(tmp_path):
    """Truth: 2^40 samples by its head, all but 64 of them never written."""
    path = tmp_path / "run.npy"
    try:
        np.lib.format.open_memmap(path, mode="w+", dtype=np.float64, shape=(2**40,))[5000:5064] = TORQUE
    except OSError:
        pytest.skip("this file system has no files of 8 TiB")
    assert "GiB of disk while they are read" in refused(path, torque(0), sample_rate_hz=RATE)


def test_only_the_chosen_rows_of_a_long_channel_are_in_memory(tmp_path):
    import tracemalloc

    import h5py

    with h5py.File(tmp_path / "run.h5", "w") as file:
        file.create_dataset("torque", data=np.resize(TORQUE, 2_000_000), chunks=(2**12,))
        file.create_dataset("other", data=np.zeros(2_000_000), chunks=(2**12,))
    how = Conditioning(window_s=(5.0, 6.0))
    tracemalloc.start()
    try:
        read(tmp_path / "run.h5", torque("torque"), sample_rate_hz=RATE, conditioning=how)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 4e6, "the whole column alone is 16 MB"
