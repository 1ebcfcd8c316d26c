"""HDF5 files that lead elsewhere or in circles. Truth: their own arrays come back, the other file's do not."""

import os
import time

import numpy as np
import pytest

import hostile_files
from hostile_files import CIRCLES, REFERENCES, SECRET, TORQUE, written
from mechid.errors import RecordError
from mechid.records import ChannelSpec, RecordSpec, open_table, read_record

pytest.importorskip("h5py")
SUFFIXES = (".h5", ".mat")


def spec(path, column, *external_files):
    torque = ChannelSpec(quantity="torque", column=column)
    return RecordSpec(name="run", path=path.name, channels=(torque,), external_files=external_files)


def read(path, column, *external_files):
    return read_record(path, spec(path, column, *external_files)).channel("torque").data


def refused(path, column, *external_files):
    with pytest.raises(RecordError) as caught:
        read(path, column, *external_files)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(path.name)
    return str(caught.value)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("build", CIRCLES)
def test_a_circle_is_cut_where_it_closes(build, suffix, tmp_path):
    path = tmp_path / f"run{suffix}"
    written(path, build)
    began = time.perf_counter()
    columns = open_table(path, path.name).columns
    assert time.perf_counter() - began < 10.0
    assert any(c.fault in ("a link back to what it is in", "links that form a cycle") for c in columns)
    assert len(columns) < 10
    np.testing.assert_array_equal(read(path, "torque"), TORQUE)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_more_paths_than_can_be_walked_are_refused(suffix, tmp_path):
    path = tmp_path / f"run{suffix}"
    written(path, hostile_files.a_ladder_of_links)
    assert path.stat().st_size < 100_000
    assert "links lead to the same groups more than 1024 times" in refused(path, "torque")


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("build", REFERENCES)
def test_numbers_of_another_file_are_refused_by_its_name(build, suffix, tmp_path):
    hostile_files.other(tmp_path)
    path = tmp_path / f"run{suffix}"
    name = written(path, build)
    message = refused(path, "x")
    assert "another file" in message
    assert message.endswith(f'allow it in the record: external_files = ["{name}"]')
    np.testing.assert_array_equal(read(path, "torque"), TORQUE)


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("build", REFERENCES)
def test_they_are_read_where_the_campaign_allows_it_and_it_is_said(build, suffix, tmp_path):
    hostile_files.other(tmp_path)
    path = tmp_path / f"run{suffix}"
    name = written(path, build)
    np.testing.assert_array_equal(read(path, "x", name), SECRET)
    warnings = read_record(path, spec(path, "x", name)).warnings
    assert warnings == (f"{path.name}: takes numbers from {name}, which its digest does not cover",)


def test_another_file_is_not_even_opened(tmp_path):
    """Truth: opening a pipe that nobody writes to never ends."""
    import h5py

    os.mkfifo(tmp_path / "other.h5")
    path = tmp_path / "run.h5"
    written(path, lambda file: file.__setitem__("x", h5py.ExternalLink(str(tmp_path / "other.h5"), "/x")))
    began = time.perf_counter()
    assert "a link to another file" in refused(path, "x")
    assert time.perf_counter() - began < 10.0


def test_a_cell_that_holds_itself_is_cut(tmp_path):
    import h5py

    def build(file):
        cell = file.create_dataset("cell", shape=(2,), dtype=h5py.ref_dtype)
        cell[:] = [cell.ref, file["torque"].ref]

    path = tmp_path / "run.mat"
    written(path, build)
    np.testing.assert_array_equal(read(path, "cell/1"), TORQUE)
    assert refused(path, "cell/0").endswith("a link back to what it is in")


def test_files_of_other_formats_name_no_others(tmp_path):
    np.savez(tmp_path / "run.npz", torque=TORQUE)
    assert "only HDF5 and MATLAB 7.3 name other files" in refused(tmp_path / "run.npz", "torque", "other.h5")
