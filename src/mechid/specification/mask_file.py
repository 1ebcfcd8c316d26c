"""Mask files: frequency and limit as two columns of a CSV or XLSX file, with units in their header."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from xml.etree import ElementTree
from zipfile import BadZipFile, ZipFile

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign.place import Place
from mechid.reading.whole import read_bytes
from mechid.units.conversion import conversion_factor
from mechid.units.headers import split_header

HEADER_REMEDY = "write one header line with both units, as frequency [Hz],limit [mN]"
MOST_BYTES = 10_000_000
_SPACE = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"
_CELL = re.compile(r"([A-Z]+)(\d+)")


def read_mask_file(path: Path, place: Place) -> tuple[FloatArray, FloatArray, str]:
    """Return frequencies in Hz, limits, and the unit of the limits.

    Parameters
    ----------
    path : Path
        ``.xlsx``: its first sheet; any other: text with commas, semicolons or tabs.
    place : Place
        Of the entry that names it.

    Raises
    ------
    InputFileError
        The file is missing, has no units in its header, or holds a cell that is no number.
    """
    rows = _sheet_rows(path, place) if path.suffix.lower() == ".xlsx" else _text_rows(path, place)
    if len(rows) < 3 or len(rows[0]) < 2:
        raise place.error(f"{path.name}: found {len(rows)} rows; {HEADER_REMEDY}, and two points or more below")
    units = [split_header(header)[1] for header in rows[0][:2]]
    if units[0] is None or units[1] is None:
        column = 1 if units[0] is None else 2
        raise place.error(f'{path.name}: column {column}: no unit in "{rows[0][column - 1]}"; {HEADER_REMEDY}')
    factor = conversion_factor(units[0], "Hz")
    if factor is None:
        raise place.error(f'{path.name}: column 1: "{units[0]}" is no unit of frequency; {HEADER_REMEDY}')
    points = np.array([_point(row, k, path, place) for k, row in enumerate(rows[1:], 2)], dtype=np.float64)
    return points[:, 0] * factor, points[:, 1].copy(), units[1]


def _point(row: list[str], line: int, path: Path, place: Place) -> tuple[float, float]:
    try:
        # semicolons separate columns where commas are decimal signs
        frequency, limit = (float(cell.replace(",", ".")) for cell in row[:2])
    except ValueError as error:
        raise place.error(f"{path.name}: line {line}: found {row[:2]}; write two numbers") from error
    return frequency, limit


def _content(path: Path, place: Place) -> bytes:
    try:
        content = read_bytes(path)
    except FileNotFoundError as error:
        raise place.error(f"{path.name}: there is no such file beside {place.file}; check the path") from error
    except OSError as error:
        raise place.error(f"{path.name}: cannot be read ({error.strerror or error}); check the path") from error
    if len(content) > MOST_BYTES:
        raise place.error(f"{path.name}: is larger than {MOST_BYTES // 1_000_000} MB, which no mask is; check the path")
    return content


def _text_rows(path: Path, place: Place) -> list[list[str]]:
    try:
        # Spreadsheet programs begin CSV files in UTF-8 with a byte order mark.
        text = _content(path, place).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise place.error(f"{path.name}: is not UTF-8 text; save it as CSV in UTF-8") from error
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    head = lines[0] if lines else ""
    delimiter = next((sign for sign in (";", "\t") if sign in head), ",")
    return [[cell.strip() for cell in row] for row in csv.reader(lines, delimiter=delimiter)]


def _sheet_rows(path: Path, place: Place) -> list[list[str]]:
    from io import BytesIO

    try:
        with ZipFile(BytesIO(_content(path, place))) as archive:
            # The unpacked size counts: a small archive can expand to gigabytes.
            if sum(info.file_size for info in archive.infolist()) > MOST_BYTES:
                raise place.error(f"{path.name}: is larger than a mask is; check the path")
            shared = _shared_texts(archive)
            sheet = min(name for name in archive.namelist() if name.startswith("xl/worksheets/sheet"))
            root = ElementTree.fromstring(archive.read(sheet))
    except (BadZipFile, ElementTree.ParseError, ValueError, KeyError) as error:
        raise place.error(f"{path.name}: is no XLSX file that can be read; save it as CSV") from error
    cells: dict[int, dict[str, str]] = {}
    for cell in root.iter(f"{_SPACE}c"):
        # Empty cells are not stored, so a cell's column follows from its address, not from its position.
        at = _CELL.fullmatch(cell.attrib.get("r", ""))
        text = _cell_text(cell, shared)
        if at and text:
            cells.setdefault(int(at[2]), {})[at[1]] = text
    return [[row.get("A", ""), row.get("B", "")] for _, row in sorted(cells.items())]


def _cell_text(cell: ElementTree.Element, shared: list[str]) -> str:
    if cell.get("t") == "inlineStr":
        return "".join(node.text or "" for node in cell.iter(f"{_SPACE}t"))
    value = cell.find(f"{_SPACE}v")
    text = (value.text if value is not None else "") or ""
    # A cell of type s holds an index into the table of shared texts.
    return shared[int(text)] if cell.get("t") == "s" and text else text


def _shared_texts(archive: ZipFile) -> list[str]:
    name = "xl/sharedStrings.xml"
    if name not in archive.namelist():
        return []
    root = ElementTree.fromstring(archive.read(name))
    return ["".join(node.text or "" for node in item.iter(f"{_SPACE}t")) for item in root.iter(f"{_SPACE}si")]
