"""HDF5 files, and MATLAB 7.3, which is one: type, shape, chunks, filters, attributes, compounds, links, references."""

from pathlib import Path
from typing import Any

import numpy as np

from fuzz.draw import Draw
from fuzz.kinds.arrays import UNITS, array, clock, expected, length, values
from fuzz.kinds.records_read import asked, damaged, read
from fuzz.trial import Kind

CLASSES = (
    "double",
    "single",
    "int16",
    "logical",
    "char",
    "cell",
    "struct",
    "table",
    "timeseries",
    "function_handle",
    "datetime",
    "",
)


def write_hdf5(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write datasets in groups, with everything that a dataset can have."""
    import h5py

    path, count = folder / draw.choice(("run.h5", "run.hdf5", "run.hdf")), length(draw)
    stamps, rate = clock(draw, count)
    columns, units, names = {}, {}, []
    with h5py.File(path, "w", libver=draw.choice((None, "latest", "earliest")), track_order=draw.chance(0.3)) as file:
        where = file
        for name in draw.choice(((), ("bench",), ("bench", "run"), ("a", "b", "c", "d"))):
            where = where.create_group(name)
        where["time"] = stamps
        prefix = where.name.strip("/")
        for k in range(draw.randint(1, 3)):
            key = f"{prefix}/Mz{k}".strip("/")
            if draw.chance(0.2):
                columns |= _compound(draw, where, f"Mz{k}", key, stamps.size)
                continue
            found = _of_hdf5(array(draw, stamps.size))
            dataset = where.create_dataset(f"Mz{k}", data=found, **_storage(draw, found))
            unit = _attributes(draw, dataset)
            own = expected(key, found)
            columns |= own
            units |= dict.fromkeys(own, unit) if unit else {}
            names.append(key)
        _odd_things(draw, file, where)
    done = {
        "file": path.name,
        "columns": columns,
        "units": {key: units.get(key, "N*m") for key in columns},
        "rate": rate,
    }
    return damaged(draw, path, asked(draw, names, done))


def _of_hdf5(found: np.ndarray) -> np.ndarray:
    if found.dtype.kind in "OMmU":
        return np.array([b"text"] * max(found.size, 1), dtype="S4")
    return found


def _storage(draw: Draw, found: np.ndarray) -> dict[str, Any]:
    """Return chunks, filters and limits of a dataset's extent."""
    if found.ndim == 0 or 0 in found.shape or draw.chance(0.5):
        return {}
    given: dict[str, Any] = {
        "chunks": tuple(draw.randint(1, size) for size in found.shape) if draw.chance(0.7) else True
    }
    if draw.chance(0.4):
        given["compression"] = draw.choice(("gzip", "lzf"))
    given["shuffle"], given["fletcher32"] = draw.chance(0.3), draw.chance(0.3)
    if found.dtype.kind in "iu" and draw.chance(0.3):
        given["scaleoffset"] = 0
        given["fletcher32"] = False
    if draw.chance(0.3):
        given["maxshape"] = tuple(None if draw.chance(0.5) else size for size in found.shape)
    if draw.chance(0.2):
        given["fillvalue"] = 7
    return given


def _attributes(draw: Draw, dataset: Any) -> str | None:
    """Give a dataset attributes of any kind; return the unit where it is one that is known."""
    import h5py

    unit = draw.choice(UNITS) if draw.chance(0.3) else None
    if unit:
        dataset.attrs[draw.choice(("unit", "units", "Unit"))] = draw.choice((unit, np.bytes_(unit)))
    for _ in range(draw.randrange(3)):
        name = (draw.text() or "empty").replace("\0", "")
        odd = (
            1.5,
            7,
            b"bytes",
            "text",
            np.arange(3.0),
            np.zeros(0),
            h5py.Empty("f8"),
            np.array([b"a", b"b"]),
            True,
            np.float16(2.0),
            np.array([[1]]),
            np.void(b"\x01\x02"),
            1j,
            "\u00fc" * 200,
        )
        if name not in dataset.attrs:
            dataset.attrs[name] = draw.choice(odd)
    if unit is None and draw.chance(0.2):
        dataset.attrs["unit"] = draw.choice((draw.text().replace("\0", ""), 5, np.zeros(2), h5py.Empty("S1")))
        return "?"
    return unit


def _compound(draw: Draw, where: Any, name: str, key: str, count: int) -> dict[str, list[float]]:
    """Write a dataset of records; its fields may be nested, arrays or texts."""
    kinds = [("t", "f8"), ("Mz", draw.choice(("f8", "f4", "i4", ">f8")))]
    more = (("pair", "f8", (2,)), ("text", "S3"), ("inner", [("a", "f8"), ("b", "i4")]), ("z", "c16"), ("flag", "?"))
    kinds += draw.sample(more, draw.randrange(3))
    if draw.chance(0.15):
        kinds = draw.choice(
            ([("r", "f8"), ("i", "f8")], [("real", "f4"), ("imag", "f4")], [("r", "f8"), ("imag", "f8")])
        )
    rows = np.zeros(count, dtype=kinds)
    for field, kind, *_ in kinds:
        if kind in ("f8", "f4", "i4", ">f8") and not _:
            rows[field] = values(draw, count, kind)
    storage = {"chunks": (max(count // 3, 1),), "compression": "gzip"} if draw.chance(0.4) and count else {}
    where.create_dataset(name, data=rows, **storage)
    if rows.dtype.names in (("r", "i"), ("real", "imag")):
        return {}
    found = {}
    for field in rows.dtype.names:
        found |= expected(f"{key}/{field}", rows[field]) if rows[field].ndim == 1 else {}
    return found


def _odd_things(draw: Draw, file: Any, where: Any) -> None:
    """Put links, references, empty things and named types beside the channels."""
    import h5py

    odd = (
        lambda: file.__setitem__(
            "soft", h5py.SoftLink(draw.choice(("/bench", "/nowhere", "/", "soft", "/soft/x", "")) or "/")
        ),
        lambda: file.__setitem__(
            "outside", h5py.ExternalLink(draw.choice(("other.h5", "/etc/hostname", "")) or "x", "/x")
        ),
        lambda: file.__setitem__("again", where),
        lambda: where.__setitem__("hard", where["time"]),
        lambda: file.create_dataset("empty", data=h5py.Empty("f8")),
        lambda: file.__setitem__("kind", np.dtype([("a", "f8")])),
        lambda: file.create_dataset("refs", data=np.array([where.ref, where["time"].ref], dtype=h5py.ref_dtype)),
        lambda: file.create_dataset("regions", data=where["time"].regionref[0:1], dtype=h5py.regionref_dtype),
        lambda: file.create_dataset("ragged", (3,), dtype=h5py.vlen_dtype(np.float64)),
        lambda: file.create_dataset("words", data=["a", "bc", ""], dtype=h5py.string_dtype()),
        lambda: file.create_dataset(
            "enum", data=np.array([0, 1] * 8), dtype=h5py.enum_dtype({"OFF": 0, "ON": 1}, basetype="i4")
        ),
        lambda: file.create_dataset("opaque", data=np.array([b"\0" * 4] * 5, dtype="V4")),
        lambda: file.create_dataset("huge", shape=(2**40,), chunks=(1024,), dtype="f8"),
        lambda: file.create_dataset("vast", shape=(2**20, 2**20), chunks=(16, 16), dtype="f8"),
        lambda: file.create_dataset("raw", shape=(16,), dtype="f8", external=[("/etc/hostname", 0, 128)]),
        lambda: _virtual(draw, file, where),
        lambda: file.create_group("g").create_group("g").create_group("g"),
        lambda: file.create_dataset("bits", data=np.arange(32) % 2 == 0),
        lambda: file.create_dataset("deep", data=np.zeros((2, 3, 4, 5))),
    )
    for put in draw.sample(odd, draw.choice((0, 0, 1, 1, 2, 4))):
        put()


def _virtual(draw: Draw, file: Any, where: Any) -> None:
    import h5py

    count = where["time"].shape[0]
    layout = h5py.VirtualLayout((max(count, 1),), float)
    source = draw.choice((".", "other.h5"))
    if count:
        layout[:] = h5py.VirtualSource(source, draw.choice((where["time"].name, "/nowhere", "/virtual")), (count,))
    file.create_virtual_dataset("virtual", layout, fillvalue=0.0)


def write_mat73(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write what MATLAB 7.3 leaves: arrays by columns, structs as groups, cells as references, texts as numbers."""
    import h5py

    path, count = folder / "run.mat", length(draw)
    stamps, rate = clock(draw, count)
    columns: dict[str, list[float]] = {}
    names = ["time"]
    with h5py.File(path, "w", userblock_size=512) as file:
        _matlab(file, "time", stamps[:, None], "double")
        refs = file.create_group("#refs#")
        for k in range(draw.randint(1, 3)):
            name, found = f"Mz{k}", _of_hdf5(array(draw, stamps.size))
            if draw.chance(0.6):
                _matlab(file, name, found, draw.choice(CLASSES) if draw.chance(0.3) else "double")
                columns |= expected(name, found) if file[name].attrs.get("MATLAB_class") == b"double" else {}
            else:
                _nested(draw, file, refs, name, found)
            names.append(name)
        if draw.chance(0.3):
            _objects(draw, file, refs)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, written by a test".ljust(512))
    done = {"file": path.name, "columns": columns, "units": dict.fromkeys(columns, "N*m"), "rate": rate}
    return damaged(draw, path, asked(draw, names, done))


def _matlab(group: Any, name: str, found: np.ndarray, kind: str) -> Any:
    group[name] = found
    if kind:
        group[name].attrs["MATLAB_class"] = np.bytes_(kind)
    return group[name]


def _nested(draw: Draw, group: Any, refs: Any, name: str, found: np.ndarray, depth: int = 0) -> None:
    """Write a struct, an array of structs, a cell, a text, an empty or a sparse array."""
    import h5py

    how = draw.randrange(7)
    if how <= 1 and depth < 3:
        inner = group.create_group(name)
        inner.attrs["MATLAB_class"] = np.bytes_("struct")
        _nested(draw, inner, refs, "a", found, depth + 1)
        _matlab(inner, "b", found, "double")
    elif how == 2:
        own = [_matlab(refs, f"{name}{depth}{k}", found, "double").ref for k in range(draw.randrange(3))]
        if draw.chance(0.2):
            own.append(h5py.Reference())
        cell = group.create_dataset(
            name, data=np.array([own], dtype=h5py.ref_dtype) if own else np.zeros(2, dtype="u8")
        )
        cell.attrs["MATLAB_class"] = np.bytes_("cell")
        if draw.chance(0.2):
            cell.attrs["MATLAB_empty"] = np.uint8(1)
    elif how == 3:
        letters = np.array([[draw.choice((65, 0x20AC, 0xD800, 0, 10))] for _ in range(draw.randint(1, 9))], dtype="u2")
        _matlab(group, name, letters, "char")
    elif how == 4:
        _matlab(group, name, np.array([0, 0], dtype="u8"), draw.choice(CLASSES)).attrs["MATLAB_empty"] = np.uint8(1)
    elif how == 5:
        sparse = group.create_group(name)
        sparse.attrs["MATLAB_sparse"] = np.uint64(3)
        sparse.attrs["MATLAB_class"] = np.bytes_("double")
        sparse["data"], sparse["ir"], sparse["jc"] = np.ones(2), np.array([0, 1]), np.array([0, 1, 2])
    else:
        complex_ = np.zeros((3, 1), dtype=[("real", "f8"), ("imag", "f8")])
        _matlab(group, name, complex_, "double")


def _objects(draw: Draw, file: Any, refs: Any) -> None:
    """Write an object of a class, and the table of objects that it points into, with numbers at random."""
    import h5py

    words = [0xDD000000, 2, 1, 1, draw.randint(0, 3), draw.randint(0, 3)]
    if draw.chance(0.4):
        words[draw.randrange(6)] = draw.choice((0, 1, 2**32 - 1, 9))
    thing = _matlab(file, "ts", np.array([words], dtype="u4"), draw.choice(("timeseries", "table", "own")))
    thing.attrs["MATLAB_object_decode"] = np.int32(draw.choice((3, 3, 1)))
    system = file.create_group("#subsystem#")
    table = np.array([draw.choice((0, 1, 2, 3, 8, 40, 60, 100, 2**31)) for _ in range(draw.randint(0, 40))], dtype="u4")
    head = np.array(
        [draw.choice((2, 3, 4, 9)), draw.randint(0, 4), *(draw.randint(0, 40) * 4 for _ in range(8))], dtype="u4"
    )
    raw = head.tobytes() + draw.choice((b"", b"Data\0Time\0Name\0", b"any\0")) + table.tobytes()
    cells = [_matlab(refs, "m0", np.frombuffer(raw, dtype="u1")[:, None], "uint8").ref]
    cells += [_matlab(refs, f"m{k + 1}", np.arange(3.0)[:, None], "double").ref for k in range(draw.randrange(4))]
    heap = system.create_dataset("MCOS", data=np.array([cells], dtype=h5py.ref_dtype))
    heap.attrs["MATLAB_class"] = np.bytes_("FileWrapper__")
    heap.attrs["MATLAB_object_decode"] = np.int32(3)


HDF5 = (
    Kind("hdf5", write_hdf5, read, codes=(4,), weight=4),
    Kind("mat73", write_mat73, read, codes=(4,), weight=4),
)
