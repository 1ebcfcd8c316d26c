"""Scaling that stands in other places than an HDF5 attribute. Truth: as in `test_scaling`."""

import numpy as np
import pytest
import scipy.io

from mechid.records import ChannelSpec
from mechid.records.formats import open_table
from object_files import write_compact_mat
from packed_files import COUNTS, RATE, TIME, write_hdf5
from records_read import read, refused, torque


def write_compound(path):
    import h5py

    kind = [("time", float), ("torque", np.int16)]
    with h5py.File(path, "w") as file:
        file["run"] = np.rec.fromarrays([TIME, COUNTS], dtype=kind)
        file["run"].attrs["scale_factor"] = 1e-4


def write_group(path):
    write_hdf5(path, COUNTS, units="N m")
    import h5py

    with h5py.File(path, "a") as file:
        file["run"].attrs["gain"] = 0.5


def write_parquet(path, **attributes):
    import pyarrow as pa
    import pyarrow.parquet as pq

    fields = [pa.field("time", pa.float64()), pa.field("torque", pa.int16(), metadata={"unit": "N m", **attributes})]
    pq.write_table(pa.table([TIME, COUNTS], schema=pa.schema(fields)), path)


def write_tdms(path, **properties):
    from nptdms import ChannelObject, TdmsWriter

    stated = {"unit_string": "N.m", "wf_increment": 1.0 / RATE, **properties}
    with TdmsWriter(path) as file:
        file.write_segment([ChannelObject("run", "torque", COUNTS, stated)])


ELSEWHERE = {
    "all fields of a compound": ("run.h5", write_compound, "scale_factor = 0.0001"),
    "a group's attribute": ("run.h5", write_group, "gain = 0.5"),
    "a field's metadata": ("run.parquet", lambda path: write_parquet(path, gain="0.5"), 'gain = "0.5"'),
    "a channel's property": ("run.tdms", lambda path: write_tdms(path, Gain=0.5), "Gain = 0.5"),
    "a struct's field": (
        "run.mat",
        lambda path: scipy.io.savemat(path, {"run": {"time": TIME, "torque": 1.0 * COUNTS, "scale": 1e-4}}),
        "scale = 0.0001",
    ),
    "a field called after the channel": (
        "run.mat",
        lambda path: scipy.io.savemat(
            path, {"run": {"time": TIME, "torque": 1.0 * COUNTS, "iA": TIME, "torque_gain": 2.0}}
        ),
        "gain = 2",
    ),
    "a struct in a struct": (
        "run.mat",
        lambda path: scipy.io.savemat(path, {"run": {"torque": {"data": COUNTS, "scale": 1e-4}, "time": TIME}}),
        "scale = 0.0001",
    ),
    "a variable beside integers": (
        "run.npz",
        lambda path: np.savez(path, time=TIME, torque=COUNTS, offset=0.5),
        "offset = 0.5",
    ),
}


@pytest.mark.parametrize("name", ELSEWHERE)
def test_a_scaling_of_other_formats_is_refused(name, tmp_path):
    file, write, said = ELSEWHERE[name]
    path = tmp_path / file
    write(path)
    column = "run/torque/data" if name == "a struct in a struct" else "torque"
    assert f"the file states {said}" in refused(path, torque(column), time=ChannelSpec(quantity="time", column="time"))


def test_the_conventions_hold_in_every_format_with_attributes(tmp_path):
    write_parquet(tmp_path / "run.parquet", scale_factor="1e-4", add_offset="0.1")
    write_tdms(tmp_path / "run.tdms", scale_factor=1e-4, add_offset=0.1)
    for name in ("run.parquet", "run.tdms"):
        np.testing.assert_allclose(read(tmp_path / name, torque("torque")).channel("torque").data, 1e-4 * COUNTS + 0.1)


def test_variables_of_a_workspace_scale_no_floats(tmp_path):
    """Truth: a gain among a program's variables may be that of anything."""
    path = tmp_path / "run.mat"
    scipy.io.savemat(path, {"time": TIME, "torque": 1.0 * COUNTS, "gain": 5.0})
    np.testing.assert_array_equal(read(path, torque("torque")).channel("torque").data, COUNTS)


def test_doubles_that_matlab_stores_as_integers_are_no_counts(tmp_path):
    path = tmp_path / "run.mat"
    write_compact_mat(path, time=TIME, torque_mNm=np.arange(200.0) % 50)
    assert scipy.io.loadmat(path)["torque_mNm"].dtype == np.uint8
    assert read(path, torque("torque")).warnings == ()


def test_classes_of_fields_and_cells_are_told_and_imaginary_parts_kept(tmp_path):
    """Truth: integers that are integers stay so, beside complex numbers, in structs and cells."""
    path = tmp_path / "run.mat"
    cells = np.empty(2, dtype=object)
    cells[:] = [COUNTS, 1.0 * COUNTS]
    scipy.io.savemat(path, {"run": {"a": COUNTS, "b": cells, "z": COUNTS + 0.5j}, "whole": COUNTS})
    columns = {column.key: column for column in open_table(path, path.name).columns}
    assert {key for key, column in columns.items() if column.whole} == {"run/a", "run/b/0", "whole"}
    assert columns["run/z"].fault == "complex numbers; a record needs real ones"


def test_netcdf_is_read(tmp_path):
    """Truth: NetCDF-4 is HDF5 whose dimensions may be datasets of no numbers; its classic format is another one."""
    import h5py

    path = tmp_path / "run.nc"
    write_hdf5(path, COUNTS, units="N m", scale_factor=1e-4)
    with h5py.File(path, "a") as file:
        file["run/n"] = np.zeros(200)
        file["run/n"].attrs["NAME"] = "This is a netCDF dimension but not a netCDF variable.       200"
    assert [column.key for column in open_table(path, path.name).columns] == ["run/time", "run/torque"]
    np.testing.assert_allclose(read(path).channel("torque").data, 1e-4 * COUNTS)
    with scipy.io.netcdf_file(tmp_path / "old.nc", "w") as file:
        file.createDimension("n", 1)
    assert "convert it to NetCDF-4" in refused(tmp_path / "old.nc")
