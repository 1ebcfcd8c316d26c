"""Detection of decimal sign and digit grouping in a text file, for each column from all of its cells.

``1,025`` may be a number with three decimals or one thousand and twenty-five. A column is unambiguous if one of its
cells is: ``0,0001`` and ``0,123`` have a decimal comma, ``1,025,000`` and ``1,025.5`` have commas between groups of
digits. An ambiguous column is rejected.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray

SIGN = r"(?:['’\x92 \xa0\u2007\u2009\u202f]|Â\xa0|â\x80[\x87\x89\x99\xaf])"
"""Apostrophes and spaces used only for digit grouping; the last alternatives are UTF-8 read as Latin-1."""
_KINDS = {
    "hundreds": r"\d{3}",
    "short": r"\d{1,2}",
    "long": r"\d{4,}",
    "round_comma": r"[1-9]\d{0,2},\d\d0",
    "round_dot": r"[1-9]\d{0,2}\.\d\d0",
    "either_comma": r"[1-9]\d{0,2},\d{3}",
    "either_dot": r"[1-9]\d{0,2}\.\d{3}",
    "comma": r"(?:\d+,\d*|,\d+)(?:[eE][+-]?\d+)?",
    "dot": r"(?:\d+\.\d*|\.\d+)(?:[eE][+-]?\d+)?",
    "grouped_comma_dot": r"[1-9]\d{0,2}(?:,\d{2,3})*,\d{3}\.\d*",
    "grouped_dot_comma": r"[1-9]\d{0,2}(?:\.\d{3})+,\d*",
    "grouped_comma": r"[1-9]\d{0,2}(?:,\d{2,3})*,\d{3}",
    "grouped_dot": r"[1-9]\d{0,2}(?:\.\d{3})+",
    "grouped_sign_dot": rf"[1-9]\d{{0,2}}(?:{SIGN}\d{{3}})+\.\d*",
    "grouped_sign_comma": rf"[1-9]\d{{0,2}}(?:{SIGN}\d{{3}})+,\d*",
    "grouped_sign": rf"[1-9]\d{{0,2}}(?:{SIGN}\d{{3}})+",
}
"""Kinds of numbers, of which the first match counts; ``either`` is one group of three digits or three decimals."""
NUMBER = re.compile("[+-]?(?:" + "|".join(f"(?P<{kind}>{pattern})" for kind, pattern in _KINDS.items()) + ")")
MARKS = {"comma": ",", "dot": ".", "sign": "sign"}
THOUSANDTHS = 1e-6
"""Tolerance for multiples of 0.001, in thousandths."""
_SIGNS = ("'", "’", "\x92", "\xa0", "\u2007", "\u2009", "\u202f", "â\x80")
_SPACED, _TWO_GROUPS = re.compile(r"\d \d{3}"), re.compile(r",\d{2,3},")
AT_ONCE = 65536
"""Number of values examined together; the first block usually decides."""
REMEDY = "export the numbers without digit grouping and with one decimal sign"

Examples = dict[str, tuple[int, str]]
"""Line and text of the first cell of each kind."""


@dataclass(frozen=True)
class Notation:
    """Notation of the numbers of one column.

    Parameters
    ----------
    decimal : str
        ``"."`` or ``","``.
    group : str
        ``""``, ``","``, ``"."``, or ``"sign"`` for any apostrophe or space.
    """

    decimal: str = "."
    group: str = ""

    def plain(self, cell: str) -> str:
        """Return a cell in a form that NumPy can parse; text that is not a number is returned unchanged."""
        if NUMBER.fullmatch(cell) is None:
            return cell
        if self.group:
            cell = re.sub(SIGN, "", cell) if self.group == "sign" else cell.replace(self.group, "")
        return cell.replace(self.decimal, ".")


def is_number(cell: str) -> bool:
    """Return whether a cell is a number in any notation."""
    try:
        float(cell)
    except ValueError:
        return NUMBER.fullmatch(cell) is not None
    return True


def has_unusual_marks(pieces: Iterable[str], separator: str | None, *, decimal_comma: bool) -> bool:
    """Return whether the samples contain marks for which every cell must be examined; most files do not.

    Parameters
    ----------
    pieces : iterable of str
        Text of the samples in pieces of many lines.
    separator : str or None
        Separator of cells; None for white space, with which numbers contain no mark except the decimal sign.
    decimal_comma : bool
        Whether the comma is assumed to be the decimal sign; if there are points too, it may group digits.
    """
    comma = dot = False
    for piece in pieces if separator is not None else ():
        comma, dot = comma or "," in piece, dot or "." in piece
        if (decimal_comma and comma and dot) or (separator == "," and '"' in piece):
            return True
        if any(sign in piece for sign in _SIGNS) or (" " in piece and _SPACED.search(piece)):
            return True
        if decimal_comma and _TWO_GROUPS.search(piece):
            return True
    return False


def note_kinds(examples: Sequence[Examples], line: int, cells: Sequence[str]) -> None:
    """Add the kinds of one line's cells to the examples of each column; surplus cells are ignored."""
    for column, cell in zip(examples, cells, strict=False):
        found = NUMBER.fullmatch(cell)
        if found and found.lastgroup and found.lastgroup not in column:
            column[found.lastgroup] = (line, cell)


def notation_of(examples: Sequence[Examples], index: int, separator: str | None) -> Notation | str:
    """Return the notation of a column, or a message if it is ambiguous.

    Parameters
    ----------
    examples : sequence of Examples
        Examples of all columns, since one column may reveal the decimal sign of the file.
    index : int
        Index of the column.
    separator : str or None
        Separator of the file's cells; commas and white space imply decimal points.
    """
    column = examples[index]
    grouping = {kind.split("_")[1] for kind in column if kind.startswith("grouped")}
    decimal = _decimals(column)
    either = {kind.split("_")[1] for kind in column if kind.startswith(("either", "round"))}
    elsewhere = {mark: place for other in examples if other is not column for mark, place in _decimals(other).items()}
    if grouping:
        left = set(decimal) | (either - grouping)
        if len(grouping) > 1 or len(left) > 1 or grouping & set(decimal):
            return _two_marks(column)
        # The grouping mark is the decimal sign of another column.
        if grouping & set(elsewhere):
            return _two_marks({**column, **{f"other_{mark}": place for mark, place in elsewhere.items()}})
        return Notation(MARKS[left.pop()] if left else ".", MARKS[grouping.pop()])
    marks = set(decimal) | either
    if len(marks) > 1:
        return _two_marks(column)
    if not marks:
        return Notation()
    mark = marks.pop()
    if decimal or "long" in column:
        return Notation(MARKS[mark])
    return _one_group_or_decimals(column, mark, elsewhere, separator)


def may_be_grouped(values: FloatArray, *, whole: bool) -> bool:
    """Return whether values may be misread thousands: below 1000, multiples of 0.001, and no fraction below 1.

    Parameters
    ----------
    values : ndarray of shape (N,)
    whole : bool
        Whether integers alone are ambiguous too: the only grouped number may be ``2,000``, read as 2.
    """
    doubtful = whole
    for start in range(0, values.size, AT_ONCE):
        size = np.abs(values[start : start + AT_ONCE])
        size = size[np.isfinite(size)]
        fraction = size != np.rint(size)
        thousandths = size * 1000.0
        is_fine = np.abs(thousandths - np.rint(thousandths)) > THOUSANDTHS
        if np.any((size >= 1000.0) | (fraction & (size < 1.0)) | is_fine):
            return False
        doubtful = doubtful or bool(np.any(fraction))
    return doubtful


def _one_group_or_decimals(
    column: Examples, mark: str, elsewhere: Mapping[str, tuple[int, str]], separator: str | None
) -> Notation | str:
    """Return the notation of a column in which every number with a mark is like ``1,025``, or a message.

    Integers of three digits in the same column suggest thousands: with decimals, they would have these too.
    """
    cell_line, cell = column.get(f"either_{mark}") or column[f"round_{mark}"]
    whole = column.get("hundreds") or column.get("short")
    grouped = "hundreds" in column or (bool(whole) and f"round_{mark}" in column and mark not in elsewhere)
    is_usual = mark == "dot" and not elsewhere and (whole is None or separator in (",", None))
    if not grouped and (mark in elsewhere or is_usual):
        return Notation(MARKS[mark])
    text = (
        f'line {cell_line}: "{cell}" may be {_as_whole(cell)} with digits grouped by thousands, or '
        f"{cell.replace(',', '.')} with a decimal {mark}"
    )
    other = next((place for name, place in elsewhere.items() if name != mark), None)
    contrast = other if other and mark not in elsewhere else whole
    if contrast:
        text += f'; line {contrast[0]} has "{contrast[1]}"'
    return f"{text}; {REMEDY}"


def _decimals(column: Examples) -> dict[str, tuple[int, str]]:
    """Return the decimal signs proved by cells of a column, each with line and text of a cell."""
    found: dict[str, tuple[int, str]] = {}
    for kind, place in column.items():
        mark = kind.rpartition("_")[2]
        if kind in ("comma", "dot") or (kind.count("_") == 2 and mark in ("comma", "dot")):
            found.setdefault(mark, place)
    return found


def _two_marks(column: Examples) -> str:
    """Return the message for a column whose cells contradict each other, with examples."""
    marked = {kind: place for kind, place in column.items() if "comma" in kind or "dot" in kind or "sign" in kind}
    told = " and ".join(f'"{cell}" in line {line}' for line, cell in sorted(marked.values())[:3])
    return f"{told} are written in different ways; {REMEDY}"


def _as_whole(cell: str) -> str:
    return cell.replace(",", "").replace(".", "")
