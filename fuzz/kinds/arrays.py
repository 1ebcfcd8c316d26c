"""Files of arrays: NumPy's own and MATLAB's up to version 7; type, shape, names and nesting are drawn."""

import struct
import zipfile
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from fuzz.draw import Draw
from fuzz.kinds.records_read import asked, damaged, read
from fuzz.trial import Kind

TYPES = (
    "f8",
    "f8",
    "f8",
    "f4",
    "f2",
    ">f8",
    ">f4",
    "i1",
    "i2",
    "i4",
    "i8",
    ">i2",
    "u1",
    "u2",
    "u4",
    "u8",
    "?",
    "c16",
    "c8",
    "S4",
    "U3",
    "M8[ms]",
    "M8[ns]",
    "m8[s]",
    "O",
    "f16",
)
UNITS = ("N*m", "mN*m", "Nm", "mNm")
RATES = (1000.0, 46.0, 10000.0, 1.0)


def length(draw: Draw) -> int:
    """Return a number of samples."""
    return draw.choice((64, 64, 64, 40, 17, 16, 15, 3, 2, 1, 0))


def values(draw: Draw, count: int, kind: str = "f8") -> np.ndarray:
    """Return `count` values of a type; some at its edges."""
    if kind == "O":
        return np.array([draw.choice((1.5, "a", None)) for _ in range(count)], dtype=object)
    if kind[0] in "SU":
        return np.array([draw.choice(("a", "bc", "1.5")) for _ in range(count)], dtype=kind)
    if kind[0] in "Mm":
        steps = np.arange(count) + draw.randint(0, 10**6)
        return steps.astype(kind)
    with np.errstate(all="ignore"):
        plain = np.array([draw.uniform(-100.0, 100.0) for _ in range(count)]) if draw.chance(0.9) else np.zeros(count)
        if draw.chance(0.3) and count:
            plain[draw.randrange(count)] = draw.choice((draw.number(), draw.whole()))
        return plain.astype(kind)


def array(draw: Draw, count: int, p: float = 0.3) -> np.ndarray:
    """Return an array: a vector of doubles, or with probability `p` of another type, and likewise of another shape."""
    kind = draw.choice(TYPES) if draw.chance(p) else "f8"
    if not draw.chance(p):
        return values(draw, count, kind)
    shape = draw.choice(
        ((count, 1), (1, count), (count, 3), (2, count), (), (1, 1, count), (3, 4, 5), (count, count), (0, 3))
    )
    return values(draw, int(np.prod(shape)), kind).reshape(shape)


def expected(key: str, found: np.ndarray) -> dict[str, list[float]]:
    """Return the columns that an array is, where there is no doubt which they are."""
    if found.dtype.kind not in "fiub" or found.ndim > 2 or found.size < 2 or 0 in found.shape:
        return {}
    found = found.astype(np.float64)
    wide = [size for size in found.shape if size > 1]
    if len(wide) == 1:
        return {key: found.ravel().tolist()}
    if found.shape[0] == found.shape[1]:
        return {}
    series = found.T if found.shape[0] > found.shape[1] else found
    return {f"{key}/{place}": one.tolist() for place, one in enumerate(series)}


def clock(draw: Draw, count: int) -> tuple[np.ndarray, float | None]:
    """Return time stamps and their rate: regular ones, or with something wrong with them."""
    rate = draw.choice(RATES)
    stamps = draw.choice((0.0, 0.0, 5.0, -1.0)) + np.arange(count) / rate
    if draw.chance(0.75) or count < 3:
        return stamps, rate if count > 2 else None
    how = draw.randrange(6)
    if how == 0:
        stamps[draw.randrange(count)] = draw.number()
    elif how == 1:
        stamps = stamps[::-1].copy()
    elif how == 2:
        stamps += np.array([draw.uniform(-0.3, 0.3) for _ in range(count)]) / rate
    elif how == 3:
        stamps = np.full(count, draw.number())
    elif how == 4:
        stamps = np.delete(stamps, draw.randrange(1, count - 1))
    else:
        stamps = stamps * draw.choice((1e-300, 1e300, 1e9, -1.0))
    return stamps, None


def named(draw: Draw, fallback: str) -> tuple[str, str | None]:
    """Return a column's name, at times with a unit at its end, and that unit."""
    if draw.chance(0.15):
        return draw.text() or fallback, None
    unit = draw.choice(UNITS) if draw.chance(0.3) else None
    return (f"{fallback} [{unit}]" if unit else fallback), unit


def write_npy(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write an array, plain or of records."""
    path, count = folder / draw.choice(("run.npy", "run.NPY")), length(draw)
    columns, units, rate, names = {}, {}, None, []
    if draw.chance(0.35):
        found = array(draw, count)
        _save(path, found)
        columns = {} if found.ndim != 1 else expected("", found)
    else:
        stamps, rate = clock(draw, count)
        count = stamps.size
        fields = {"time": stamps}
        for k in range(draw.randint(1, 3)):
            name, unit = named(draw, f"Mz{k}")
            fields[name] = values(draw, count, draw.choice(TYPES[:17]) if draw.chance(0.3) else "f8")
            columns |= expected(name, fields[name])
            units[name] = unit or "N*m"
        names = list(fields)
        kinds = [(name, one.dtype) for name, one in fields.items()]
        found = np.zeros(count, dtype=kinds)
        for name, one in fields.items():
            found[name] = one
        _save(path, found)
    if draw.chance(0.15):
        _change_head(draw, path)
        columns, rate = {}, None
        return asked(draw, names, {"file": path.name, "damaged": True})
    return damaged(
        draw, path, asked(draw, names, {"file": path.name, "columns": columns, "units": units, "rate": rate})
    )


def _save(path: Path, found: np.ndarray) -> None:
    with path.open("wb") as file:
        np.save(file, found, allow_pickle=True)


def _change_head(draw: Draw, path: Path) -> None:
    """Write the head anew with a field that is something else; the numbers stay."""
    content = path.read_bytes()
    size = struct.unpack("<H", content[8:10])[0]
    head = content[10 : 10 + size].decode("latin-1").strip()
    for old, new in draw.sample(
        (
            ("'fortran_order': False", "'fortran_order': True"),
            ("'descr'", "'desc'"),
            ("(", "(-"),
            ("(", "(9999999999,"),
            ("f8", draw.choice(("f4", "V8", "O", "i8", "c16", "zz"))),
            ("{", "["),
            ("'shape'", "'fortran_order'"),
            ("64", str(draw.whole())),
            ("False", draw.text()),
        ),
        2,
    ):
        head = head.replace(old, new, 1)
    body = head.encode("utf-8", "replace").ljust(size)[: max(size, len(head)) % 65000]
    version = draw.choice((1, 1, 1, 2, 3, 9))
    length_of = struct.pack("<H" if version == 1 else "<I", len(body))
    path.write_bytes(content[:6] + bytes([version, 0]) + length_of + body + content[10 + size :])


def write_npz(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write an archive; members may be of any array, or none."""
    path, count = folder / "run.npz", length(draw)
    stamps, rate = clock(draw, count)
    columns, units, members = {}, {}, {"time": stamps}
    for k in range(draw.randint(0, 3)):
        name, _ = named(draw, f"Mz{k}")
        members[name.replace("/", "_") or "x"] = array(draw, stamps.size)
    with zipfile.ZipFile(path, "w", draw.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))) as archive:
        for name, found in members.items():
            written = BytesIO()
            np.lib.format.write_array(written, np.asanyarray(found), allow_pickle=True)
            archive.writestr(f"{name}.npy", written.getvalue())
            if name.isidentifier():
                columns |= expected(name, found)
        if draw.chance(0.1):
            archive.writestr(
                draw.choice(("notes.txt", "x.npy", "folder/", "a/b.npy")), draw.choice((b"", b"\x93NUMPY", b"text"))
            )
    units = dict.fromkeys(columns, "N*m")
    done = {"file": path.name, "columns": columns, "units": units, "rate": rate}
    return damaged(draw, path, asked(draw, list(members), done))


def write_mat(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write variables of version 4 or 5: arrays, structs, cells, texts, nested to a depth."""
    import scipy.io

    path, count = folder / "run.mat", length(draw)
    stamps, rate = clock(draw, count)
    version = draw.choice(("4", "5", "5", "5"))
    content: dict[str, Any] = {"time": stamps}
    columns: dict[str, list[float]] = expected("time", stamps)
    for k in range(draw.randint(1, 3)):
        name = f"Mz{k}"
        found = array(draw, stamps.size)
        if found.dtype.kind in "MmO" or found.dtype.str[1:] in ("f2", "f16"):
            found = np.zeros(stamps.size)
        if version == "5" and draw.chance(0.4):
            content[name] = _nest(draw, found, 0)
        else:
            content[name] = found
            columns |= expected(name, found)
    try:
        scipy.io.savemat(
            path, content, format=version, do_compression=draw.chance(0.5), oned_as=draw.choice(("row", "column"))
        )
    except (TypeError, ValueError, NotImplementedError):  # version 4 has no such type
        content, columns = {"time": stamps}, expected("time", stamps)
        scipy.io.savemat(path, content)
    if draw.chance(0.15) and version == "5":
        _change_elements(draw, path)
        return asked(draw, list(content), {"file": path.name, "damaged": True})
    done = {"file": path.name, "columns": columns, "units": dict.fromkeys(columns, "N*m"), "rate": rate}
    return damaged(draw, path, asked(draw, list(content), done))


def _nest(draw: Draw, found: np.ndarray, depth: int) -> Any:
    """Return an array within structs and cells."""
    kind = draw.randrange(5 if depth < 3 else 1)
    if kind == 0:
        return found
    if kind == 1:
        return {"a": _nest(draw, found, depth + 1), "note": draw.choice(("text", "", 1.0))}
    if kind == 2:
        cell = np.empty(draw.randint(0, 3), dtype=object)
        for k in range(cell.size):
            cell[k] = _nest(draw, found, depth + 1)
        return cell
    if kind == 3:
        rows = np.zeros(draw.randint(1, 3), dtype=[("x", object), ("y", object)])
        for row in rows:
            row["x"], row["y"] = found, draw.choice(("t", 2.0, np.zeros(0)))
        return rows
    return [found, found]


def _change_elements(draw: Draw, path: Path) -> None:
    """Change types, lengths and flags of data elements, which stand at multiples of 8 bytes."""
    content = bytearray(path.read_bytes())
    for _ in range(draw.randint(1, 3)):
        at = 128 + 8 * draw.randrange(max((len(content) - 128) // 8, 1)) + draw.choice((0, 4))
        if at + 4 <= len(content):
            content[at : at + 4] = struct.pack(
                "<I", draw.choice((0, 1, 5, 6, 9, 14, 15, 17, 255, 2**31 - 1, 2**32 - 1, draw.randrange(64)))
            )
    path.write_bytes(content)


ARRAYS = (
    Kind("npy", write_npy, read, codes=(4,)),
    Kind("npz", write_npz, read, codes=(4,)),
    Kind("mat", write_mat, read, codes=(4,), weight=3),
)
