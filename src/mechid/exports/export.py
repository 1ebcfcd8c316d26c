"""Export of a finished fit as files for use without mechid, with their verification."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from mechid.display import DisplayedResult
from mechid.errors import UsageError, did_you_mean
from mechid.exports.document import PAGES, PRESENTER, export_numbers
from mechid.exports.handover import Handover
from mechid.exports.stand import describe_mechanism
from mechid.identification.result.estimate_file import json_text
from mechid.locks import hold_folder
from mechid.reading.whole import read_text
from mechid.writing import creating_folder, refuse_input_file, staging_folder, write_atomically

FORMAT = "mechid-export/1"
FILE_NAME = "mechid_export.json"
TARGETS: Mapping[str, str] = {
    "c": "mechid.exports.c.target",
    "fmu": "mechid.exports.fmu.target",
    "linear": "mechid.exports.linear.target",
    "tables": "mechid.exports.tables.target",
}
"""Module of each target; its function `write_target` writes a handover into an empty folder."""


@dataclass(frozen=True)
class Verification:
    """Comparison of the written files with the result of mechid.

    Attributes
    ----------
    against : str
        Description of the reference.
    largest_error, rms_error : float
        Errors in the unit of the compared quantity; N m unless `against` says otherwise.
    """

    against: str
    largest_error: float
    rms_error: float


@dataclass(frozen=True)
class TargetOutput:
    """Output of a target.

    Attributes
    ----------
    files : tuple of str
        Names of the files in the folder.
    checked : Verification or None
        None if nothing could be compared; `words` gives the reason.
    words : tuple of str
        Remarks for the user, on reliability and omissions.
    figures : tuple of (str, str, callable)
        Name, text alternative, and a function that draws it; each becomes an SVG and a PNG file.
    """

    files: tuple[str, ...]
    checked: Verification | None
    words: tuple[str, ...] = ()
    figures: tuple[tuple[str, str, Callable[[], Any]], ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all files in the folder, those of the figures included."""
        return (*self.files, *(f"{name}.{suffix}" for name, _, _ in self.figures for suffix in ("svg", "png")))


@dataclass(frozen=True, repr=False)
class Exported(DisplayedResult):
    """Result of an export: target, folder and written files."""

    target: str
    folder: Path
    written: TargetOutput
    provenance: Mapping[str, Any]
    earlier: tuple[str, ...] = ()
    """Files of earlier exports, of other targets, in the folder."""

    def to_dict(self) -> dict[str, Any]:
        """Return the content of mechid_export.json."""
        checked = self.written.checked
        return {
            "format": FORMAT,
            "target": self.target,
            "mechanism": self.provenance["mechanism"],
            "files": list(self.written.names),
            "earlier_files": sorted(set(self.earlier) - {FILE_NAME, *self.written.names}),
            "checked": asdict(checked) if checked else None,
            "words": list(self.written.words),
            "provenance": dict(self.provenance),
        }


def write_export(source: Handover, target: str, folder: Path, options: object = None) -> Exported:
    """Write a handover for one target, with a summary in `mechid_export.json`.

    All files are written and verified in a temporary folder, and moved into place when complete.
    """
    if target not in TARGETS:
        near = did_you_mean(target, TARGETS) or f"; there are {', '.join(TARGETS)}"
        raise UsageError(f'export: found "{target}"{near}')
    module = import_module(TARGETS[target])
    chosen = _options(module, target, options)
    source = replace(source, stands=_which(source, chosen))
    write: Callable[..., TargetOutput] = module.write_target
    with hold_folder(folder), creating_folder(folder), staging_folder(folder, "export") as beside:
        earlier = _earlier_files(folder)
        done = Exported(target, folder, write(source, beside, *chosen), source.provenance, earlier)
        write_atomically(beside / FILE_NAME, json_text(done.to_dict()))
        PRESENTER.write(done, export_numbers(done), beside)
        names = (
            FILE_NAME,
            *PAGES,
            *done.written.names,
        )
        # After the files are complete, since only then all their names are known.
        _refuse_foreign(folder, names, (*earlier, *PAGES) if earlier else ())
        for name in names:
            (beside / name).replace(folder / name)
    return done


def _which(source: Handover, chosen: tuple[object, ...]) -> str:
    """Describe the exported mechanism, according to the options of the target."""
    stand = any(getattr(options, "stand", False) for options in chosen)
    values = {name: value for options in chosen for name, value in getattr(options, "values", {}).items()}
    return describe_mechanism(source.mechanism, values, stand=stand)


def _earlier_files(folder: Path) -> tuple[str, ...]:
    """Return the files of earlier exports in a folder, from their summary; empty without a valid summary."""
    try:
        found = json.loads(read_text(folder / FILE_NAME))
        return (FILE_NAME, *map(str, found["files"]), *map(str, found.get("earlier_files", ())))
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return ()


def _refuse_foreign(folder: Path, names: Iterable[str], earlier: Collection[str]) -> None:
    """Raise UsageError if a file to be written exists and comes from no export of mechid, as a main.c of the user."""
    for name in names:
        refuse_input_file(folder / name)
        if os.path.lexists(folder / name) and name not in earlier:
            raise UsageError(
                f"{folder}: holds {name}, which no export of mechid has left and is not replaced; give another folder"
            )


def read_options(texts: Iterable[str]) -> dict[str, str]:
    """Read options by name from arguments of the command line.

    Raises
    ------
    UsageError
        An option has no name or no value, or a name is repeated.

    Examples
    --------
    >>> read_options(["node=1001", "rates=23,46"])
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
    """Return the `Options` of a target, also from strings; empty if none are given."""
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
