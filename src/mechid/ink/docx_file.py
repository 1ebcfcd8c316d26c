"""Files of Word: the refusal where python-docx is absent, and writing with equal bytes for equal content."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Iterable, Mapping
from importlib.util import find_spec
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZIP_STORED, ZipFile, ZipInfo

from mechid.errors import UsageError
from mechid.ink.document import Document
from mechid.writing import atomic_file

EXTRA = "office"
EPOCH = (1980, 1, 1, 0, 0, 0)
"""Time of every entry of the archive, the earliest that ZIP can hold."""
EVIDENCE = (".json", ".csv", ".toml")
"""Suffixes of the files of a result that a test report lists with their digests."""


def refuse_without_docx() -> None:
    """Raise UsageError if python-docx is not installed; for use before any work.

    Raises
    ------
    UsageError
        It is not installed; the message has the command that installs it.
    """
    if find_spec("docx") is None:
        raise UsageError(f'docx: a Word document needs python-docx; pip install "mechid[{EXTRA}]"')


def write_docx(document: Document, pictures: Mapping[str, Path], path: Path) -> Path:
    """Write a document as a Word file, with the PNG files of its figures by name, and return its path."""
    from mechid.ink.in_docx import document_docx

    made = io.BytesIO()
    document_docx(document, pictures).save(made)
    with atomic_file(path) as beside:
        beside.write_bytes(_without_times(made))
    return path


def _without_times(made: io.BytesIO) -> bytes:
    """Return an archive in which no entry has the time of its writing."""
    out = io.BytesIO()
    with ZipFile(made) as source, ZipFile(out, "w") as archive:
        for name in source.namelist():
            entry = ZipInfo(name, EPOCH)
            entry.compress_type = ZIP_STORED if name.endswith(".png") else ZIP_DEFLATED
            archive.writestr(entry, source.read(name))
    return out.getvalue()


def text_digests(files: Iterable[Path]) -> dict[str, str]:
    """Return the SHA-256 of the files of numbers by name; workbooks hold the time of their writing."""
    own = [path for path in files if path.suffix in EVIDENCE]
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in own}


def picture_files(folder: Path, names: Iterable[str]) -> dict[str, Path]:
    """Return the PNG files of figures in a folder by name."""
    return {name: path for name in names if (path := folder / f"{name}.png").is_file()}
