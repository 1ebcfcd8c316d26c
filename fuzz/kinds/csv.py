"""Records as text: separator, decimal sign, encoding, header, units, quotes, line ends, cells that are no numbers."""

from pathlib import Path
from typing import Any

from fuzz.draw import Draw
from fuzz.kinds.arrays import clock, length, named, values
from fuzz.kinds.records_read import asked, damaged

CELLS = (
    "",
    "nan",
    "NaN",
    "inf",
    "-inf",
    "1e400",
    "1e-400",
    "0x10",
    "1_000",
    "1,5",
    "1.5.2",
    "--1",
    "+1",
    "1e",
    "abc",
    " 1 ",
    '"2.5"',
    "١٢",
    "1d5",
    "9" * 400,
    "1 2",
    "\0",
    "=1+1",
    "#",
    "TRUE",
)
ENCODINGS = ("utf-8", "utf-8", "utf-8-sig", "utf-16", "latin-1", "utf-16-be", "utf-32")


def write_csv(draw: Draw, folder: Path) -> dict[str, Any]:
    """Write a table of numbers as instruments do."""
    path, count = folder / f"run{draw.choice(('.csv', '.csv', '.tsv', '.txt', '.dat', '.asc'))}", length(draw)
    stamps, rate = clock(draw, count)
    data = {"time_s": stamps}
    units = {}
    for k in range(draw.randint(1, 3)):
        name, unit = named(draw, f"Mz{k}")
        data[name] = values(draw, stamps.size)
        units[name] = unit or "N*m"
    separator = draw.choice((",", ",", ",", ";", ";", "\t", "\t", " ", "   "))
    comma = separator in (";", "\t") and draw.chance(0.4)
    form = draw.choice(("{!r}", "{!r}", "{:.17e}", "{:.17g}"))
    rows = [
        [form.format(float(x)).replace(".", "," if comma else ".") for x in row]
        for row in zip(*data.values(), strict=True)
    ]
    is_changed = _change(draw, rows)
    lines = [separator.join(row) for row in rows]
    header = _header(draw, list(data), separator)
    is_changed |= header != [separator.join(data)]
    head = [draw.text().replace("\0", "") for _ in range(draw.choice((0, 0, 0, 1, 3, 30)))]
    is_changed |= bool(head) or separator.isspace()
    end = draw.choice(("\n", "\n", "\r\n", "\r"))
    text = end.join([*head, *header, *lines]) + (end if draw.chance(0.8) else "")
    encoding = draw.choice(ENCODINGS)
    path.write_bytes(text.encode(encoding, "replace"))
    known = (
        not is_changed
        and encoding in ("utf-8", "utf-8-sig", "latin-1", "utf-16")
        and all(map(_plain, data))
        and count > 1
    )
    columns = {name: found.tolist() for name, found in data.items()} if known else {}
    done = {"file": path.name, "columns": columns, "units": units, "rate": rate if known else None}
    return damaged(draw, path, asked(draw, list(data), done))


def _plain(name: str) -> bool:
    return name.isascii() and not set(name) & set(',;\t"\n\r #') and bool(name)


def _header(draw: Draw, names: list[str], separator: str) -> list[str]:
    """Return no, one or two header lines."""
    how = draw.randrange(10)
    quoted = [f'"{name}"' for name in names]
    return {
        0: [],
        1: [separator.join(names), separator.join(["s", *["mN*m"] * (len(names) - 1)])],
        2: [separator.join(quoted)],
        3: ["# " + separator.join(names)],
        4: [separator.join(names[:-1])],
        5: [separator.join(names), "", ""],
    }.get(how, [separator.join(names)])


def _change(draw: Draw, rows: list[list[str]]) -> bool:
    """Change cells, drop or repeat rows; return whether anything was done."""
    if not rows or draw.chance(0.5):
        return False
    for _ in range(draw.choice((1, 1, 3))):
        at = draw.randrange(len(rows))
        how = draw.randrange(5)
        if how <= 2 and rows[at]:
            rows[at][draw.randrange(len(rows[at]))] = draw.choice(CELLS) if draw.chance(0.8) else draw.text()
        elif how == 3:
            rows.insert(at, rows[at][: draw.randint(0, len(rows[at]))])
        else:
            rows[at] = [*rows[at], "0.0"]
    return True
