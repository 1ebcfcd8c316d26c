"""Files of instruments: text, TDMS, universal files, Parquet."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from fuzz.draw import Draw
from fuzz.kinds.arrays import RATES, UNITS, clock, expected, length, named, values
from fuzz.kinds.csv import write_csv
from fuzz.kinds.records_read import asked, damaged, read
from fuzz.kinds.tdms import write_tdms
from fuzz.trial import Kind

ARROW = (
    "float64",
    "float64",
    "float32",
    "float16",
    "int8",
    "int16",
    "int32",
    "int64",
    "uint8",
    "uint16",
    "uint32",
    "uint64",
    "bool",
    "string",
    "binary",
    "timestamp",
    "date",
    "decimal",
    "list",
    "dictionary",
    "null",
    "duration",
)


def write_uff(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write data sets 58 as text or binary, with changed heads, beside sets of other kinds."""
    import pyuff

    path, rate = folder / draw.choice(("run.uff", "run.unv", "run.u58")), draw.choice(RATES)
    binary, spacing, count = draw.choice((0, 0, 1)), draw.choice((1, 1, 0)), length(draw) or 1
    sets, columns, units = [], {}, {}
    for k in range(draw.randint(1, 3)):
        data = values(draw, count if draw.chance(0.9) else length(draw) or 1)
        name, unit = draw.choice((f"Mz{k}", f"Mz{k}", "NONE", "")), draw.choice(UNITS)
        given: dict[str, Any] = {
            "binary": binary,
            "func_type": 1,
            "rsp_node": 1,
            "rsp_dir": 1,
            "ref_dir": 0,
            "ref_node": 0,
            "data": data,
            "x": np.arange(data.size) / rate,
            "id1": "T-12",
            "rsp_ent_name": name or "x",
            "abscissa_spacing": spacing,
            "abscissa_spec_data_type": 17,
            "abscissa_axis_units_lab": "s",
            "ordinate_spec_data_type": 0,
            "ordinate_axis_units_lab": unit,
            "orddenom_spec_data_type": 0,
            "z_axis_spec_data_type": 0,
            "abscissa_min": 0.0,
            "abscissa_inc": 1.0 / rate,
        }
        if draw.chance(0.3):
            key = draw.choice(
                (
                    "func_type",
                    "abscissa_min",
                    "abscissa_inc",
                    "rsp_dir",
                    "id1",
                    "ordinate_axis_units_lab",
                    "abscissa_axis_units_lab",
                    "abscissa_spec_data_type",
                )
            )
            given[key] = (
                draw.text()[:20].replace("\0", "")
                if isinstance(given[key], str)
                else draw.choice((0, 2, 4, -1, 1e-3, 18))
            )
        if draw.chance(0.1):
            given["data"] = data * (1.0 + 0.5j)
        sets.append(pyuff.prepare_58(**given))
        units[f"{k}/{name}"] = unit
    with warnings.catch_warnings(action="ignore", category=ResourceWarning):
        pyuff.UFF(str(path)).write_sets(sets, mode="add")
    if draw.chance(0.25):
        _change_lines(draw, path)
        return asked(draw, list(units), {"file": path.name, "damaged": True})
    return damaged(draw, path, asked(draw, list(units), {"file": path.name, "columns": columns, "units": units}))


def _change_lines(draw: Draw, path: Path) -> None:
    """Change numbers in the heads of the data sets, drop lines, put other sets beside."""
    lines = path.read_bytes().split(b"\n")
    for _ in range(draw.randint(1, 3)):
        at = draw.randrange(min(len(lines), 16))
        how, line = draw.randrange(5), lines[at]
        if how == 0:
            del lines[at]
        elif how == 1:
            lines.insert(at, draw.choice((b"    -1", b"    58", b"   151", b"    15", b"", b"x" * 300)))
        elif line:
            words = line.split()
            if words:
                words[draw.randrange(len(words))] = draw.choice(
                    (b"0", b"-1", b"2", b"5", b"6", b"99999999", b"1e400", b"nan", b"x")
                )
                lines[at] = b" ".join(words) if how == 2 else words[0].rjust(10) + line[10:]
    path.write_bytes(b"\n".join(lines))


def write_parquet(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write columns of any type in row groups, with metadata."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    path, count = folder / draw.choice(("run.parquet", "run.pq")), length(draw)
    stamps, rate = clock(draw, count)
    fields, data = [pa.field("time", pa.float64(), metadata={"unit": "s"})], [pa.array(stamps)]
    columns, units, with_metadata = expected("time", stamps), {}, draw.chance(0.8)
    for k in range(draw.randint(1, 3)):
        name, unit = named(draw, f"Mz{k}")
        found = _column(draw, stamps.size, draw.choice(ARROW) if draw.chance(0.3) else "float64")
        own = draw.choice(UNITS) if unit is None and draw.chance(0.2) else None
        if name in [field.name for field in fields]:
            columns.pop(name, None)
        elif isinstance(found, np.ndarray):
            columns |= expected(name, found)
        units[name] = unit or (with_metadata and own) or "N*m"
        data.append(pa.array(found) if isinstance(found, np.ndarray) else found)
        fields.append(pa.field(name, data[-1].type, metadata={"unit": own} if own else None))
    schema = pa.schema(fields, metadata={"serial": "T", draw.text(): draw.text()} if draw.chance(0.5) else None)
    table = pa.Table.from_arrays(data, schema=schema)
    pq.write_table(
        table,
        path,
        row_group_size=draw.choice((1, 7, 20, 1000)),
        use_dictionary=draw.chance(0.5),
        compression=draw.choice(("none", "snappy", "gzip", "zstd", "lz4")),
        version=draw.choice(("1.0", "2.4", "2.6")),
        data_page_version=draw.choice(("1.0", "2.0")),
        write_statistics=draw.chance(0.5),
        store_schema=with_metadata,
    )
    names = [field.name for field in fields]
    done = {"file": path.name, "columns": columns, "units": units, "rate": rate}
    return damaged(draw, path, asked(draw, names, done))


def _column(draw: Draw, count: int, kind: str) -> Any:
    """Return a column of one of Arrow's types, in part missing."""
    import pyarrow as pa

    plain = values(draw, count)
    with np.errstate(all="ignore"):
        if kind in ("float64", "float32", "float16", "bool") or kind.lstrip("u").startswith("int"):
            found = plain.astype(kind)
            if draw.chance(0.2) and count:
                return pa.array(
                    [None if draw.chance(0.2) else x for x in found.tolist()], type=pa.from_numpy_dtype(found.dtype)
                )
            return found
    texts = [draw.choice(("a", "b", None)) for _ in range(count)]
    made = {
        "string": lambda: pa.array(texts, type=pa.string()),
        "binary": lambda: pa.array([b"x"] * count, type=pa.binary()),
        "timestamp": lambda: pa.array(
            np.arange(count) * 10**6,
            type=pa.timestamp(draw.choice(("s", "ms", "us", "ns")), tz=draw.choice((None, "UTC"))),
        ),
        "date": lambda: pa.array(np.arange(count, dtype="i4"), type=pa.date32()),
        "decimal": lambda: pa.array([1] * count, type=pa.decimal128(10, 2)),
        "list": lambda: pa.array([[1.0, 2.0]] * count, type=pa.list_(pa.float64())),
        "dictionary": lambda: pa.array(texts).dictionary_encode(),
        "null": lambda: pa.nulls(count),
        "duration": lambda: pa.array(np.arange(count), type=pa.duration("ms")),
    }
    return made[kind]()


INSTRUMENTS = (
    Kind("csv", write_csv, read, codes=(4,), weight=6),
    Kind("tdms", write_tdms, read, codes=(4,), weight=3),
    Kind("uff", write_uff, read, codes=(4,), weight=3),
    Kind("parquet", write_parquet, read, codes=(4,), weight=3),
)
