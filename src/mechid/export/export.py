"""Export: a finished fit as files that others use without mechid, and what was checked of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from mechid.campaign import Campaign
from mechid.errors import UsageError, did_you_mean
from mechid.export.handover import Handover, handover
from mechid.identification.result.estimate_file import json_text
from mechid.identification.result.fit import Fit
from mechid.writing import writable, write_whole

FORMAT = "mechid-export/1"
FILE_NAME = "mechid_export.json"
TARGETS: Mapping[str, str] = {"tables": "mechid.export.tables.target"}
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


@dataclass(frozen=True)
class Exported:
    """What was written, where and for which target."""

    target: str
    folder: Path
    written: Written
    provenance: Mapping[str, Any]

    def to_dict(self) -> dict[str, Any]:
        """Return the content of mechid_export.json."""
        checked = self.written.checked
        return {
            "format": FORMAT, "target": self.target, "files": list(self.written.files),
            "checked": asdict(checked) if checked else None, "words": list(self.written.words),
            "provenance": dict(self.provenance),
        }  # fmt: skip


def export(fit: Fit, *, to: str, out: Path | str, campaign: Campaign | None = None, anyway: bool = False) -> Exported:
    """Write a finished fit for others: C text, FMUs, a linear model, tables.

    Parameters
    ----------
    fit : Fit
    to : {"c", "fmu", "linear", "tables"}
    out : Path
        Folder for the files; made where missing.
    campaign : Campaign or None
        Of which it was identified: its commands are those under which what is written is compared with mechid.
    anyway : bool
        Whether a fit that failed is written too.

    Raises
    ------
    UsageError
        There is no such target, it cannot express the mechanism, or the folder cannot be written to.
    FitError
        The fit has failed.
    """
    return exported(handover(fit.to_dict(), fit.mechanism, campaign, anyway=anyway), to, Path(out))


def exported(what: Handover, target: str, folder: Path) -> Exported:
    """Write a handover for one target, and what was written and checked as `mechid_export.json`.

    All is made and checked aside, and is put in place when it is whole.
    """
    if target not in TARGETS:
        near = did_you_mean(target, TARGETS) or f"; there are {', '.join(TARGETS)}"
        raise UsageError(f'export: found "{target}"{near}')
    write: Callable[[Handover, Path], Written] = import_module(TARGETS[target]).written
    with writable(folder), TemporaryDirectory(prefix=".mechid_export_", dir=folder) as aside:
        done = Exported(target, folder, write(what, Path(aside)), what.provenance)
        write_whole(Path(aside) / FILE_NAME, json_text(done.to_dict()))
        for name in (*done.written.files, FILE_NAME):
            (Path(aside) / name).replace(folder / name)
    return done
