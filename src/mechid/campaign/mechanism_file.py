"""Reader of the mechanism file: parameter values, bounds and priors, in the plant's names and units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from mechid.campaign.mechanism_structure import Structure, divisors, read_structure
from mechid.campaign.mesh_entry import with_mesh_numbers
from mechid.campaign.parameter_entry import read_parameter
from mechid.campaign.place import Place, describe_entry, in_unit, is_table_list
from mechid.campaign.toml_file import read_toml
from mechid.campaign.unfinished_template import without_template
from mechid.command.entry import is_table
from mechid.errors import did_you_mean
from mechid.parameter import Declaration, Parameter, Status
from mechid.plant.mechanism import Mechanism
from mechid.plant.tables import LISTS, OPTIONAL, table_of


def load_mechanism(path: Path | str) -> Mechanism:
    """Load a mechanism from its file.

    A bare number is a known value. A table ``{ value, min, max }`` is estimated, starting at `value`;
    `sigma` in it is the standard deviation of a prior.

    Parameters
    ----------
    path : Path
        TOML file, as ``mechanism.toml``.

    Raises
    ------
    InputFileError
        The file is missing or invalid; one line with the place and a remedy.

    Examples
    --------
    >>> import mechid
    >>> mechid.load_mechanism("mechanism.toml").value("gear.ratio")  # doctest: +SKIP
    50.0
    """
    return mechanism_from_table(read_toml(Path(path), "mechanism"), Path(path).name, Path(path).parent)


def mechanism_from_table(table: Mapping[str, Any], label: str, folder: Path = Path()) -> Mechanism:
    """Make a mechanism from a table read from TOML.

    `label` names the file in messages; `folder` is the base of the paths in the table.
    """
    place = Place(label)
    table = with_mesh_numbers(without_template(table, place), place)
    structure = read_structure(table, place, folder)
    entries = dict(_entries(table, structure, place))
    parameters = {
        name: _parameter(name, declaration, entries, structure, place)
        for name, declaration in structure.plant.declarations.items()
    }
    # After all parameters are read, since a tied one copies the value of its master.
    _tie(parameters, entries, structure)
    mechanism = Mechanism(plant=structure.plant, parameters=parameters, options=structure.options)
    for name, wrong in mechanism.contradictions():
        raise place.key(name).error(wrong)
    return mechanism


def mechanism_warnings(mechanism: Mechanism, label: str) -> tuple[str, ...]:
    """Return one line for each legal but suspicious value."""
    return tuple(
        f"{label}: {name} = {q.value:.9g}: {doubt}"
        for name, q in mechanism.parameters.items()
        if (doubt := q.declaration.doubt(q.value))
    )


def _parameter(
    name: str, declaration: Declaration, entries: Mapping[str, Any], structure: Structure, place: Place
) -> Parameter:
    if name in entries:
        divides = name in divisors(structure.plant)
        return read_parameter(entries[name], name, declaration, place.key(name), divides=divides)
    if declaration.default is None and name not in structure.plant.related_parameters("tied_to"):
        table, _, key = name.rpartition(".")
        plain = table_of(name)
        header = f"[[{plain}]]" if plain in LISTS else f"[{table}]"
        raise place.key(name).error(
            f"missing; write {key} under {header}, {declaration.meaning}{in_unit(declaration.unit)}"
        )
    return Parameter(name=name, value=declaration.default or 0.0, declaration=declaration)


def _tie(parameters: dict[str, Parameter], entries: Mapping[str, Any], structure: Structure) -> None:
    """Tie parameters missing from the file to their masters."""
    for name, master in structure.plant.related_parameters("tied_to").items():
        if name not in entries:
            parameters[name] = Parameter(
                name=name,
                value=parameters[master].value,
                declaration=parameters[name].declaration,
                status=Status.TIED,
                tied_to=master,
            )


def _entries(table: Mapping[str, Any], structure: Structure, place: Place) -> Iterator[tuple[str, Any]]:
    """Yield the parameters of the file by dotted name, without options; refuse names unknown to the plant."""
    known = (*structure.plant.declarations, *structure.options)
    tables = {name[:at] for name in known for at in _dots(name)}
    for name, entry in _flat(table, "", tables):
        if name in tables:
            raise place.key(name).error(f"{describe_entry(entry)}; write a table, [{name}]")
        if name not in known:
            kind = "table" if is_table(entry) and "." not in name else "key"
            if law := structure.law_with(name):
                raise place.key(name).error(f'unknown key; it belongs to {law[0]} = "{law[1]}"')
            raise place.key(name).error(f"unknown {kind}{_nearest(name, known, tables)}")
        if name not in structure.options:
            yield name, entry


def _flat(entry: Mapping[str, Any], prefix: str, tables: set[str]) -> Iterator[tuple[str, Any]]:
    """Yield dotted names and entries, descending only into tables of the plant."""
    for key, value in entry.items():
        name = f"{prefix}{key}"
        if name in tables and is_table(value):
            yield from _flat(value, f"{name}.", tables)
        elif name in LISTS and is_table_list(value):
            for index, item in enumerate(value):
                yield from _flat(item, f"{name}.{index}.", tables)
        else:
            yield name, value


def _dots(name: str) -> list[int]:
    return [at for at, character in enumerate(name) if character == "."]


def _nearest(name: str, known: tuple[str, ...], tables: set[str]) -> str:
    """Suggest a name: a similar one in the same table, the same key in another table, or a similar one anywhere."""
    table, _, key = name.rpartition(".")
    if name in OPTIONAL:
        return f"; its own are in a table, [{name}]"
    names = [*known, *sorted(tables)]
    siblings = [other.rpartition(".")[2] for other in names if other.rpartition(".")[0] == table]
    elsewhere = [other for other in known if other.endswith(f".{key}")]
    # A long table is similar to each of its own keys.
    tables_elsewhere = [other for other in (*LISTS, *OPTIONAL) if other != table]
    if absent := get_close_matches(name, tables_elsewhere, n=1, cutoff=0.8):
        place = absent[0].rpartition(".")
        return f'; did you mean "{place[2] if place[0] == table else absent[0]}"?'
    if near := did_you_mean(key, siblings):
        return near
    if elsewhere:
        return f'; did you mean "{elsewhere[0]}"?'
    # Keys of this table are compared above; here the common part of their names would make any of them similar.
    others = [other for other in names if other != table and other.rpartition(".")[0] != table]
    return did_you_mean(name, others) or f"; the keys here are {', '.join(siblings)}"
