"""Writer of mechanism files, which read back to equal values and carry the meaning of each parameter."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path

from mechid.campaign.mechanism_structure import ASSEMBLY
from mechid.campaign.mesh_entry import join_teeth
from mechid.campaign.toml_file import toml_number, toml_text
from mechid.parameter import Parameter, Status
from mechid.plant.gear_mesh import DRIVEN, DRIVER, TEETH
from mechid.plant.mechanism import Mechanism
from mechid.plant.tables import LISTS, TABLES
from mechid.writing import creating_folder, write_atomically


def write_mechanism(mechanism: Mechanism, path: Path | str, header_comment: str = "") -> None:
    """Write a mechanism file atomically; `load_mechanism` reads it back to equal values.

    Parameters
    ----------
    mechanism : Mechanism
        Free parameters are written with bounds and sigma, even if the fit froze them.
    path : Path
        An existing file is replaced.
    header_comment : str
        Comment at the top of the file.

    Raises
    ------
    UsageError
        The file cannot be written.

    Examples
    --------
    >>> import mechid
    >>> mechid.write_mechanism(mechid.catalogue_mechanism(), "mechanism.toml")  # doctest: +SKIP
    """
    with creating_folder(Path(path).parent):
        write_atomically(Path(path), mechanism_text(mechanism, header_comment))


def mechanism_text(mechanism: Mechanism, header_comment: str = "", notes: Mapping[str, str] | None = None) -> str:
    """Return the text of a mechanism file.

    Parameters
    ----------
    mechanism : Mechanism
    header_comment : str
        Comment at the top of the file.
    notes : mapping of str to str, or None
        Remarks on parameters and options, by dotted name. A remark shared by a whole table is written above it,
        others at the end of their line.
    """
    lines = [f"# {line}".rstrip() for line in header_comment.splitlines()]
    lines += [""] if lines else []
    lines.append(f"{ASSEMBLY} = {toml_text(mechanism.options[ASSEMBLY])}")
    for table, parameters in _by_table(mechanism).items():
        lines += ["", *_table(table, parameters, mechanism, notes or {})]
    return "\n".join(lines) + "\n"


def appendix_text(mechanism: Mechanism, names: Collection[str], written: Mechanism) -> str:
    """Return the tables of some parameters, to append to a mechanism file that lacks them.

    Entries of a table that the file already contains are commented out, since TOML allows a table only once.

    Parameters
    ----------
    mechanism : Mechanism
        Mechanism with the parameters.
    names : collection of str
        Dotted names of the parameters; an entry of a list is written with all its keys.
    written : Mechanism
        Mechanism as in its file.
    """
    places = {name.rpartition(".")[0] for name in names}
    listed = {place for place in places if place.rpartition(".")[2].isdigit()}
    # A table of a list is complete only with all keys of its entry.
    whole = {name for name in mechanism.parameters if name.rpartition(".")[0] in listed} | set(names)
    text = tables_text(mechanism, whole)
    if not places & {name.rpartition(".")[0] for name in written.parameters}:
        return text
    lines = [f"into the table that is there already: {text.splitlines()[0]}", *text.splitlines()[1:]]
    return "\n".join(f"# {line}".rstrip() for line in lines) + "\n"


def tables_text(mechanism: Mechanism, names: Collection[str]) -> str:
    """Return the tables of some parameters, without other keys, to append to a file that lacks them."""
    lines: list[str] = []
    for table, parameters in _by_table(mechanism).items():
        chosen = [q for q in parameters if q.name in names]
        lines += [*_table(table, chosen, mechanism, {}), ""] if chosen else []
    return "\n".join(lines)


def _by_table(mechanism: Mechanism) -> dict[str, list[Parameter]]:
    """Group the parameters by table; TOML requires the keys of a table before its subtables."""
    grouped: dict[str, list[Parameter]] = {}
    for name, parameter in mechanism.parameters.items():
        grouped.setdefault(name.rpartition(".")[0], []).append(parameter)
    return grouped


def _table(
    table: str, parameters: Sequence[Parameter], mechanism: Mechanism, notes: Mapping[str, str]
) -> Iterator[str]:
    plain = next((name for name in LISTS if table.startswith(f"{name}.")), table)
    title = TABLES[plain].title if plain in TABLES else ""
    remarks = {notes.get(q.name, "") for q in parameters}
    shared = remarks.pop() if len(remarks) == 1 else ""
    if shared:
        yield f"# {shared}"
    yield (f"[[{plain}]]" if plain != table else f"[{plain}]") + (f"  # {title}" if title else "")
    for option, value in mechanism.options.items():
        if option.rpartition(".")[0] == table and "." in option:
            note = "" if shared else notes.get(option, "")
            written = value if value.isdigit() else toml_text(value)
            yield f"{option.rpartition('.')[2]} = {written}" + (f"  # {note}" if note else "")
    entries = {q.name.rpartition(".")[2]: _entry(q, mechanism.value(q.name)) for q in parameters}
    comments = {q.name.rpartition(".")[2]: _comment(q, "" if shared else notes.get(q.name, "")) for q in parameters}
    if DRIVER in entries and DRIVEN in entries:
        entries, comments = join_teeth(entries), {**comments, TEETH: "teeth of the driving and of the driven wheel"}
    pairs = [(entry, comments[key]) for key, entry in entries.items()]
    # Aligned comments keep the file readable as a table.
    width = max(len(entry) for entry, _ in pairs)
    yield from (f"{entry:<{width}}  # {comment}" for entry, comment in pairs)


def _entry(q: Parameter, value: float) -> str:
    key = q.name.rpartition(".")[2]
    if q.status is Status.TIED:
        return f"# {key} = {toml_number(value)}"
    if q.status is Status.KNOWN:
        return f"{key} = {_known_value(q)}"
    numbers = {"value": q.value, "min": q.min, "max": q.max, "sigma": q.sigma}
    written = {k: v for k, v in numbers.items() if v is not None and math.isfinite(v)}
    return f"{key} = {{ {', '.join(f'{k} = {toml_number(v)}' for k, v in written.items())} }}"


def _known_value(q: Parameter) -> str:
    """Return a known value; counts have no decimal point."""
    is_count = q.declaration.unit == "1" and q.value.is_integer() and abs(q.value) < 1e15
    return str(int(q.value)) if is_count else toml_number(q.value)


def _comment(q: Parameter, note: str = "") -> str:
    d = q.declaration
    unit = "" if d.unit == "1" else f", {d.unit}"
    tied = f"; left out, it follows {q.tied_to}" if q.status is Status.TIED else ""
    return f"{d.symbol}{unit}: {d.meaning}{tied}" + (f"; {note}" if note else "")
