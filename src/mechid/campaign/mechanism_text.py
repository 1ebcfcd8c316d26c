"""A mechanism written down as a file that reads back to the same values, each line with its meaning."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path

from mechid.campaign.mechanism_structure import ASSEMBLY
from mechid.campaign.toml_file import toml_number, toml_text
from mechid.parameter import Parameter, Status
from mechid.plant.mechanism import Mechanism
from mechid.plant.tables import LISTS, TABLES
from mechid.writing import creating_folder, write_atomically


def write_mechanism(mechanism: Mechanism, path: Path | str, header_comment: str = "") -> None:
    """Write a mechanism file that `load_mechanism` reads back to equal values; whole or not at all.

    Parameters
    ----------
    mechanism : Mechanism
        What was free is written as a table with its bounds and sigma, also where the fit froze it.
    path : Path
        An earlier file is replaced.
    header_comment : str
        Comes first, each of its lines as a comment.

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
    """Return the file's text.

    Parameters
    ----------
    mechanism : Mechanism
    header_comment : str
        Comes first, each of its lines as a comment.
    notes : mapping of str to str, or None
        Remarks on parameters and options, by dotted name. One that holds for a whole table stands above it, others
        end the line of their entry.
    """
    lines = [f"# {line}".rstrip() for line in header_comment.splitlines()]
    lines += [""] if lines else []
    lines.append(f"{ASSEMBLY} = {toml_text(mechanism.options[ASSEMBLY])}")
    for table, parameters in _by_table(mechanism).items():
        lines += ["", *_table(table, parameters, mechanism, notes or {})]
    return "\n".join(lines) + "\n"


def appendix_text(mechanism: Mechanism, names: Collection[str], written: Mechanism) -> str:
    """Return the tables that declare some parameters, for the end of the file of a mechanism that lacks them.

    Entries of a table that this file has already are comments there: a table stands once in a file.

    Parameters
    ----------
    mechanism : Mechanism
        With the parameters.
    names : collection of str
        Their dotted names; an entry of a list is written with all its keys.
    written : Mechanism
        As its file has it.
    """
    places = {name.rpartition(".")[0] for name in names}
    listed = {place for place in places if place.rpartition(".")[2].isdigit()}
    whole = {name for name in mechanism.parameters if name.rpartition(".")[0] in listed} | set(names)
    text = tables_text(mechanism, whole)
    if not places & {name.rpartition(".")[0] for name in written.parameters}:
        return text
    lines = [f"into the table that is there already: {text.splitlines()[0]}", *text.splitlines()[1:]]
    return "\n".join(f"# {line}".rstrip() for line in lines) + "\n"


def tables_text(mechanism: Mechanism, names: Collection[str]) -> str:
    """Return the tables that some parameters stand in, with these alone, for the end of a file that has them not."""
    lines: list[str] = []
    for table, parameters in _by_table(mechanism).items():
        chosen = [q for q in parameters if q.name in names]
        lines += [*_table(table, chosen, mechanism, {}), ""] if chosen else []
    return "\n".join(lines)


def _by_table(mechanism: Mechanism) -> dict[str, list[Parameter]]:
    """Group the parameters: a table's own keys have to stand before its tables of detents."""
    grouped: dict[str, list[Parameter]] = {}
    for name, parameter in mechanism.parameters.items():
        grouped.setdefault(name.rpartition(".")[0], []).append(parameter)
    return grouped


def _table(
    table: str, parameters: Sequence[Parameter], mechanism: Mechanism, notes: Mapping[str, str]
) -> Iterator[str]:
    plain = next((name for name in LISTS if table.startswith(f"{name}.")), table)
    title = TABLES[plain].title if plain in TABLES else ""
    said = {notes.get(q.name, "") for q in parameters}
    of_all = said.pop() if len(said) == 1 else ""
    if of_all:
        yield f"# {of_all}"
    yield (f"[[{plain}]]" if plain != table else f"[{plain}]") + (f"  # {title}" if title else "")
    for option, value in mechanism.options.items():
        if option.rpartition(".")[0] == table and "." in option:
            note = "" if of_all else notes.get(option, "")
            yield f"{option.rpartition('.')[2]} = {toml_text(value)}" + (f"  # {note}" if note else "")
    pairs = [
        (_entry(q, mechanism.value(q.name)), _comment(q, "" if of_all else notes.get(q.name, ""))) for q in parameters
    ]
    width = max(len(entry) for entry, _ in pairs)
    yield from (f"{entry:<{width}}  # {comment}" for entry, comment in pairs)


def _entry(q: Parameter, value: float) -> str:
    key = q.name.rpartition(".")[2]
    if q.status is Status.TIED:
        return f"# {key} = {toml_number(value)}"
    if q.status is Status.KNOWN:
        return f"{key} = {_known(q)}"
    numbers = {"value": q.value, "min": q.min, "max": q.max, "sigma": q.sigma}
    written = {k: v for k, v in numbers.items() if v is not None and math.isfinite(v)}
    return f"{key} = {{ {', '.join(f'{k} = {toml_number(v)}' for k, v in written.items())} }}"


def _known(q: Parameter) -> str:
    """Return a known value; a count without a decimal point."""
    is_count = q.declaration.unit == "1" and q.value.is_integer() and abs(q.value) < 1e15
    return str(int(q.value)) if is_count else toml_number(q.value)


def _comment(q: Parameter, note: str = "") -> str:
    d = q.declaration
    unit = "" if d.unit == "1" else f", {d.unit}"
    tied = f"; left out, it follows {q.tied_to}" if q.status is Status.TIED else ""
    return f"{d.symbol}{unit}: {d.meaning}{tied}" + (f"; {note}" if note else "")
