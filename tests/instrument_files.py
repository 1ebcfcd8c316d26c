"""Small files of every format, each by a named builder from the same arrays."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import scipy.io

RATE = 1000.0
TIME = np.arange(64) / RATE
TORQUE = np.sin(0.3 * np.arange(64.0))
CURRENT = np.cos(0.2 * np.arange(64.0))


@dataclass
class Format:
    """How a file of one format is written, what to ask for to get the torque, and what it says of itself."""

    name: str
    write: Callable
    torque: object
    metadata: dict = field(default_factory=dict)
    has_time: bool = True


def write_csv(path):
    rows = "".join(f"{t:.6f},{1e3 * m:.9e},{i:.9e}\n" for t, m, i in zip(TIME, TORQUE, CURRENT, strict=True))
    path.write_text("time_s,Mz_mNm,iA\n" + rows)


def write_mat5(path):
    content = {"run": {"time": TIME, "Mz_mNm": 1e3 * TORQUE, "iA": CURRENT}, "serial": "T-12", "kt": 0.4}
    scipy.io.savemat(path, content, do_compression=True)


def write_mat5_plain(path):
    scipy.io.savemat(path, {"run": {"time": TIME, "Mz_mNm": 1e3 * TORQUE, "iA": CURRENT}}, do_compression=False)


def write_hdf5(path):
    import h5py

    with h5py.File(path, "w") as file:
        file.attrs["serial"] = "T-12"
        file["bench/run/time"] = TIME
        file["bench/run/Mz"] = 1e3 * TORQUE
        file["bench/run/Mz"].attrs["unit"] = "mN*m"
        file["bench/run/Mz"].attrs["sensitivity"] = 2.5
        file["bench/run/iA"] = CURRENT
        file["kt"] = 0.4


def write_mat73(path):
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        run = file.create_group("run")
        run.attrs["MATLAB_class"] = np.bytes_("struct")
        for name, values in (("time", TIME), ("Mz_mNm", 1e3 * TORQUE), ("iA", CURRENT)):
            run[name] = values[:, None]
            run[name].attrs["MATLAB_class"] = np.bytes_("double")
        file["serial"] = np.array([[ord(letter)] for letter in "T-12"], dtype=np.uint16)
        file["serial"].attrs["MATLAB_class"] = np.bytes_("char")
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, written by a test".ljust(512))


def write_tdms(path):
    from nptdms import ChannelObject, RootObject, TdmsWriter

    start = {"wf_increment": 1.0 / RATE, "wf_start_offset": 0.0, "wf_start_time": np.datetime64("2024-05-06T07:08:09")}
    torque = ChannelObject("run", "Mz", 1e3 * TORQUE, {**start, "unit_string": "mN.m", "sensitivity": 2.5})
    current = ChannelObject("run", "iA", CURRENT, {**start, "unit_string": "Amps"})
    with TdmsWriter(path) as file:
        file.write_segment([RootObject({"serial": "T-12"}), torque, current])


def data_set_58(name, values, unit, **changes):
    import pyuff

    given = {
        "binary": 0,
        "func_type": 1,
        "rsp_node": 1,
        "rsp_dir": 1,
        "ref_dir": 0,
        "ref_node": 0,
        "data": values,
        "x": TIME,
        "id1": "T-12",
        "rsp_ent_name": name,
        "abscissa_spacing": 1,
        "abscissa_spec_data_type": 17,
        "abscissa_axis_units_lab": "s",
        "ordinate_spec_data_type": 0,
        "ordinate_axis_units_lab": unit,
        "orddenom_spec_data_type": 0,
        "z_axis_spec_data_type": 0,
        "abscissa_min": 0.0,
        "abscissa_inc": 1.0 / RATE,
    } | changes
    return pyuff.prepare_58(**given)


def write_uff(path, **changes):
    import pyuff

    sets = [data_set_58("Mz", 1e3 * TORQUE, "mNm", **changes), data_set_58("iA", CURRENT, "A", **changes)]
    path.unlink(missing_ok=True)  # pyuff does not overwrite binary data sets whole, and leaves their file open
    with warnings.catch_warnings(action="ignore", category=ResourceWarning):
        pyuff.UFF(str(path)).write_sets(sets, mode="add")


def write_parquet(path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    fields = [
        pa.field("time", pa.float64(), metadata={"unit": "s"}),
        pa.field("Mz [mNm]", pa.float64()),
        pa.field("iA", pa.float64()),
    ]
    schema = pa.schema(fields, metadata={"serial": "T-12"})
    table = pa.table([TIME, 1e3 * TORQUE, CURRENT], schema=schema)
    pq.write_table(table, path, row_group_size=20)


def write_npz(path):
    np.savez(path, time=TIME, Mz_mNm=1e3 * TORQUE, iA=CURRENT, kt=0.4)


def write_npy(path):
    kind = [("time", float), ("Mz_mNm", float), ("iA", float)]
    np.save(path, np.rec.fromarrays([TIME, 1e3 * TORQUE, CURRENT], dtype=kind).view(np.ndarray))


FORMATS = {
    "csv": Format("run.csv", write_csv, "Mz"),
    "mat 5, compressed": Format("run.mat", write_mat5, "run/Mz_mNm", {"serial": "T-12", "kt": 0.4}),
    "mat 5": Format("run.mat", write_mat5_plain, "Mz"),
    "mat 7.3": Format("run.mat", write_mat73, "run/Mz_mNm", {"serial": "T-12"}),
    "hdf5": Format("run.h5", write_hdf5, "/bench/run/Mz", {"serial": "T-12", "kt": 0.4}),
    "tdms": Format("run.tdms", write_tdms, "run/Mz", {"serial": "T-12"}, has_time=False),
    "uff 58": Format("run.uff", write_uff, "Mz", has_time=False),
    "uff 58b": Format("run.unv", lambda path: write_uff(path, binary=1), "0/Mz", has_time=False),
    "uff 58, uneven": Format("run.uff", lambda path: write_uff(path, abscissa_spacing=0), "0/Mz"),
    "parquet": Format("run.parquet", write_parquet, "Mz", {"serial": "T-12"}),
    "npz": Format("run.npz", write_npz, "Mz_mNm", {"kt": 0.4}),
    "npy": Format("run.npy", write_npy, "Mz"),
}
