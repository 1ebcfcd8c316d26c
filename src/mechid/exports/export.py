"""Export: a finished fit as files that others use without mechid, and what was checked of them."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from mechid.errors import UsageError, did_you_mean
from mechid.exports.document import PAGES, PRESENTER, export_numbers
from mechid.exports.handover import Handover
from mechid.exports.stand import which_mechanism
from mechid.holding import hold_folder
from mechid.identification.result.estimate_file import json_text
from mechid.reading.whole import read_text
from mechid.shown import Shown
from mechid.writing import creating_folder, refuse_input_file, staging_folder, write_atomically

FORMAT = "mechid-export/1"
FILE_NAME = "mechid_export.json"
TARGETS: Mapping[str, str] = {
    "c": "mechid.exports.c.target",
    "fmu": "mechid.exports.fmu.target",
    "linear": "mechid.exports.linear.target",
    "tables": "mechid.exports.tables.target",
}
"""Module of each target by its name; its `written` takes a handover and an empty folder, and writes there."""


@dataclass(frozen=True)
class Checked:
    """How what was written compares with mechid's own result.

    Attributes
    ----------
    against : str
        With what it was compared, in words.
    largest_error, rms_error : float
        In the unit of what was compared, N m where nothing else is said in `against`.
    """

    against: str
    largest_error: float
    rms_error: float


@dataclass(frozen=True)
class Written:
    """What a target has written.

    Attributes
    ----------
    files : tuple of str
        Names in the folder.
    checked : Checked or None
        None where nothing could be compared; `words` says why.
    words : tuple of str
        What its user has to know: how far it can be trusted, what it leaves away.
    """

    files: tuple[str, ...]
    checked: Checked | None
    words: tuple[str, ...] = ()


@dataclass(frozen=True, repr=False)
class Exported(Shown):
    """What was written, where and for which target."""

    target: str
    folder: Path
    written: Written
    provenance: Mapping[str, Any]
    earlier: tuple[str, ...] = ()
    """What earlier exports, of other targets, have left in the folder."""

    def to_dict(self) -> dict[str, Any]:
        """Return the content of mechid_export.json."""
        checked = self.written.checked
        return {
            "format": FORMAT,
            "target": self.target,
            "mechanism": self.provenance["mechanism"],
            "files": list(self.written.files),
            "earlier_files": sorted(set(self.earlier) - {FILE_NAME, *self.written.files}),
            "checked": asdict(checked) if checked else None,
            "words": list(self.written.words),
            "provenance": dict(self.provenance),
        }


def exported(what: Handover, target: str, folder: Path, options: object = None) -> Exported:
    """Write a handover for one target, and what was written and checked as `mechid_export.json`.

    All is made and checked aside, and is put in place when it is whole.
    """
    if target not in TARGETS:
        near = did_you_mean(target, TARGETS) or f"; there are {', '.join(TARGETS)}"
        raise UsageError(f'export: found "{target}"{near}')
    module = import_module(TARGETS[target])
    asked = _options(module, target, options)
    what = replace(what, stands=_which(what, asked))
    write: Callable[..., Written] = module.written
    with hold_folder(folder), creating_folder(folder), staging_folder(folder, "export") as beside:
        earlier = _left(folder)
        done = Exported(target, folder, write(what, beside, *asked), what.provenance, earlier)
        write_atomically(beside / FILE_NAME, json_text(done.to_dict()))
        PRESENTER.write(done, export_numbers(done), beside)
        names = (
            FILE_NAME,
            *PAGES,
            *done.written.files,
        )
        _refuse_foreign(folder, names, (*earlier, *PAGES) if earlier else ())
        for name in names:
            (beside / name).replace(folder / name)
    return done


def _which(what: Handover, asked: tuple[object, ...]) -> str:
    """Return which mechanism is handed on, by a target's options."""
    stand = any(getattr(options, "stand", False) for options in asked)
    values = {name: value for options in asked for name, value in getattr(options, "values", {}).items()}
    return which_mechanism(what.mechanism, values, stand=stand)


def _left(folder: Path) -> tuple[str, ...]:
    """Return the files that earlier exports have left in a folder, by their list; none where that is no such list."""
    try:
        found = json.loads(read_text(folder / FILE_NAME))
        return (FILE_NAME, *map(str, found["files"]), *map(str, found.get("earlier_files", ())))
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return ()


def _refuse_foreign(folder: Path, names: Iterable[str], earlier: Collection[str]) -> None:
    """Raise UsageError where a file to be written is there and is none of mechid's exports, as somebody's main.c."""
    for name in names:
        refuse_input_file(folder / name)
        if os.path.lexists(folder / name) and name not in earlier:
            raise UsageError(
                f"{folder}: holds {name}, which no export of mechid has left and is not replaced; give another folder"
            )


def named_options(texts: Iterable[str]) -> dict[str, str]:
    """Return options by name, from texts as the command line has them.

    Raises
    ------
    UsageError
        One has no name, or a name comes twice.

    Examples
    --------
    >>> named_options(["node=1001", "rates=23,46"])
    {'node': '1001', 'rates': '23,46'}
    """
    found: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name or name in found:
            why = "is there twice" if name in found else "has no name" if equals else "has no value"
            raise UsageError(f'--option: found "{text}", which {why}; write NAME=VALUE, each name once')
        found[name.strip()] = value.strip()
    return found


def _options(module: ModuleType, target: str, given: object) -> tuple[object, ...]:
    """Return what a target is asked for beside the fit: its `Options`, also from texts; none where nothing is."""
    if not given:
        return ()
    kind = getattr(module, "Options", None)
    if kind is None:
        raise UsageError(f'export: the target "{target}" takes no options; leave them out')
    if isinstance(given, Mapping):
        return (kind.read(given),)
    if not isinstance(given, kind):
        raise UsageError(f'export: found options of another target; "{target}" takes {kind.__module__}.{kind.__name__}')
    return (given,)
