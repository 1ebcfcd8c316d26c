"""Detection of units above the samples of a text file: in a line of units, after a label, or in a sentence.

The text of an ambiguous line is kept with the columns. A column without a stated unit is then rejected with this text
(`mechid.records.columns`), so that a unit in the file is never overlooked.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from mechid.units import SI_UNIT, is_unit, measures, split_header, to_si_factor, unit_within

Line = tuple[int, str]
"""Line number from 1, and text."""
Splitter = Callable[[str], Sequence[str]]
COMMENT = re.compile(r"\A\s*(?:#+|%+|//+|!+|\*+|rem\b)[\s:]*", re.IGNORECASE)
"""Beginning of a comment."""
LABEL = re.compile(
    r"[\s\"\[(]*(?:(?:channel|column|y|x|signal|kanal)s?[ _-]?)?"
    r"(?:units?|einheit(?:en)?|unités?|unit[àa]|unidad(?:es)?)(?:[ _-]?labels?)?[\s\"\])]*(?:[:=;,\t|]|$|\s)",
    re.IGNORECASE,
)
"""Label at the beginning of a line of units in instruments' files."""
NO_UNIT = ("", "-", "--", "none", "n/a", "1")
OTHER_UNITS = re.compile(
    r"°c|degc|k|%|[mhk]?bar|[hkm]?pa|psi|k?g|mv/v|k?hz|ohm|w|db|[uµ]m/m|m/s(?:²|\^?2)|1/s|counts?|digits?|lsb",
    re.IGNORECASE,
)
"""Units of quantities that no channel measures, accepted within a line of units."""
LONGEST_UNIT = 16
LONGEST_UNKNOWN = 8
"""Maximum length of a unit and of an unknown unit; longer texts are words."""
LONGEST_PARTICLE = 3
"""Maximum length of a word that may be a unit by coincidence."""
ALIASES = (
    re.compile(r"t|tout|time|zeit|temps|tempo", re.IGNORECASE),
    re.compile(r"\w* ?torque|\w*moment|couple|coppia|m[xyz]?", re.IGNORECASE),
)
"""Names of a quantity in several languages; a comment may use another name than the header."""
_JOIN = (
    r"(?:\s*(?:columns?|channels?|values?|data|axis|base|stamps?|units?|einheit(?:en)?"
    r"|is|are|was|recorded|measured|given|stated|gemessen|wird|ist))*"
)
_TOKEN = r"(?P<unit>[^\s\[\](),;:=|]+(?: [^\s\[\](),;:=|\d]+)?)"
_BRACKETS = r"\[(?P<square>[^\]]+)\]|\((?P<round>[^)]+)\)"
_STATEMENT = _JOIN + rf"\s*(?:{_BRACKETS}|(?:\bin\b|\ben\b|[:=/])\s*{_TOKEN})"
_LABELLED = _JOIN + rf"\s*(?:{_BRACKETS}|(?:\bin\b|[:=/;,|])?\s*{_TOKEN})"
"""The same in a line that mentions units: ``Time unit;ms``, ``units: time ms, torque mNm``."""
_SPEAKS_OF_UNITS = re.compile(r"\b(?:[hvxy]?_?units?|einheit(?:en)?)\b", re.IGNORECASE)
_VALUE = re.compile(r"[\])]?[\s:=;,|]*[+-]?\d[\d.]*(?:[eE][+-]?\d+)?\s*(?:$|[;,|\t])")
"""Number after a unit, which shows that the unit belongs to a setting."""
_ANYWHERE = re.compile(rf"{_BRACKETS}|(?:\bin\b|\ben\b|[:=])\s*{_TOKEN}|(?P<word>[^\s,;:=()\[\]]+)")


@dataclass
class StatedUnit:
    """Unit of one column according to the lines above the samples.

    Parameters
    ----------
    unit : str or None
    doubts : mapping of str to str
        Text that may state the unit, by quantity.
    """

    unit: str | None = None
    doubts: dict[str, str] = field(default_factory=dict)


def is_line_of_units(cells: Sequence[str], *, whole: bool = True) -> bool:
    """Return whether cells are units; if not `whole`, half of them suffice if one is a unit of time.

    Examples
    --------
    >>> is_line_of_units(["s", "[N m]", "°C", "-"]), is_line_of_units(["time", "torque"])
    (True, False)
    """
    stated = [cell for cell in map(bare_unit, cells) if cell.lower() not in NO_UNIT]
    if not all(map(_is_short, stated)) or not any(map(_is_listed, stated)):
        return False
    measured = [cell for cell in stated if is_unit(cell)]
    unknown = [cell for cell in stated if cell not in measured and OTHER_UNITS.fullmatch(cell) is None]
    if not unknown:
        return bool(measured)
    if whole or 2 * len(unknown) > len(stated) or max(map(len, unknown)) > LONGEST_UNKNOWN:
        return False
    return any(measures(cell, "time") for cell in measured)


def bare_unit(cell: str) -> str:
    """Return a unit without brackets, quotes and comment mark."""
    return (COMMENT.sub("", cell, count=1) or cell).strip().strip("[]()\"' ")


def is_comment(line: str) -> bool:
    """Return whether a line begins with a comment mark."""
    return COMMENT.match(line) is not None


def stated_units(names: Sequence[str], lines: Sequence[Line], split: Splitter, header: int) -> list[StatedUnit]:
    """Return the units that lines above or below the header state for the columns.

    Parameters
    ----------
    names : sequence of str
        Cells of the header.
    lines : sequence of Line
        Other lines before the samples.
    split : callable
        Function that splits a line into cells like the samples.
    header : int
        Line number of the header; an adjacent line of units may contain unknown units.
    """
    found = [StatedUnit() for _ in names]
    for number, text in lines:
        left = _add_by_name(found, names, (number, text))
        cells = _cells_of_units(text, len(names), split, beside=abs(number - header) == 1) if left == text else None
        if cells:
            for column, cell in zip(found, cells, strict=True):
                _add_unit(column, bare_unit(cell), number)
        else:
            _add_doubts(found, (number, left))
    return found


def states_units_of(names: Sequence[str], text: str) -> bool:
    """Return whether a line states units of columns by name."""
    return _add_by_name([StatedUnit() for _ in names], names, (0, text)) != text


def _is_short(cell: str) -> bool:
    return len(cell) <= LONGEST_UNIT and not re.fullmatch(r"[+-]?[\d.,]+", cell)


def _cells_of_units(text: str, columns: int, split: Splitter, *, beside: bool) -> Sequence[str] | None:
    """Return the units of all columns if a line is a line of units, with or without a label; otherwise None."""
    body = COMMENT.sub("", text.strip("\r\n"), count=1)
    label = LABEL.match(body)
    rest = body[label.end() :] if label else body
    splitters: tuple[Splitter, ...] = (split, _split_at_marks, _split_brackets, str.split)
    for splitter in splitters:
        cells = list(splitter(rest))
        # Lines of units written by instruments may end in empty cells.
        while label and len(cells) > 1 and not cells[-1].strip() and (len(cells) > columns or label[0][:1] in "yY"):
            cells.pop()
        if label and len(cells) == columns - 1 and splitter is split:
            # In LabVIEW's files the label occupies the time column.
            cells = ["", *cells]
        if len(cells) == columns and is_line_of_units(cells, whole=not (label or beside)):
            return cells
    return None


def _split_at_marks(text: str) -> list[str]:
    return re.split(r"[,;\t|]", text)


def _split_brackets(text: str) -> list[str]:
    return re.findall(r"\[[^\]]*\]", text)


def _add_unit(column: StatedUnit, unit: str, line: int) -> None:
    """Add a unit to a column; two different units make the column ambiguous for every quantity."""
    if unit.lower() in NO_UNIT:
        return
    if column.unit is not None and column.unit != unit:
        column.doubts = dict.fromkeys(SI_UNIT, f'line {line} says "{unit}", and another line "{column.unit}"')
    column.unit = unit if not column.doubts else None


def _add_by_name(found: Sequence[StatedUnit], names: Sequence[str], line: Line) -> str:
    """Add the units that a line states by column name, as in ``torque in mNm``; return the rest of the line."""
    number, text = line
    left = text
    statement = _LABELLED if _SPEAKS_OF_UNITS.search(text) else _STATEMENT
    for column, name in zip(found, names, strict=True):
        bare, in_name = split_header(name)
        for called in _name_patterns(bare, names):
            for match in re.finditer(rf"(?<![\w-])(?:{called})(?![\w-]){statement}", text, re.IGNORECASE):
                unit = _unit_of(match)
                if unit is None or _VALUE.match(text, match.end()):
                    continue
                left = left.replace(match[0], "", 1)
                if in_name is None:
                    _add_unit(column, unit, number)
    return left


def _name_patterns(name: str, names: Sequence[str]) -> list[str]:
    """Return patterns of a column's names: its own, and those of its quantity if no other column measures it."""
    patterns = [re.escape(name.strip())] if name.strip() else []
    for alias in ALIASES:
        if alias.fullmatch(name.strip()) and sum(bool(alias.fullmatch(split_header(n)[0].strip())) for n in names) == 1:
            patterns.append(alias.pattern)
    return patterns


def _unit_of(match: re.Match[str]) -> str | None:
    """Return the unit in a matched statement; of two words the first if both together are not a unit."""
    text = (match["square"] or match["round"] or match["unit"] or "").strip().strip("\"'").rstrip(".")
    for candidate in (text, text.partition(" ")[0]):
        if (
            candidate
            and _is_short(candidate)
            and (match["square"] or _is_unambiguous(candidate))
            and is_unit(candidate)
        ):
            return candidate
    return None


def _is_listed(text: str) -> bool:
    """Return whether a text is one of the most common units, without loading Pint."""
    joined = re.sub(r"[\s·*.-]", "", text)
    listed = any(name == "x" and unit for name, unit in (split_header(f"x_{word}") for word in (text, joined)))
    return listed or joined.lower().startswith("sec") or any(unit_within(joined, quantity) for quantity in SI_UNIT)


def _is_unambiguous(text: str) -> bool:
    """Return whether a text in a sentence is a unit rather than a word: ``a`` and ``das`` are units of time to Pint."""
    return _is_listed(text) or len(text) > LONGEST_PARTICLE or not text.isalpha()


def _add_doubts(found: Sequence[StatedUnit], line: Line) -> None:
    """Record the units of a line as doubts of all columns to which they may belong.

    A unit is a doubt for a quantity if it measures the quantity in a unit other than SI, or if the line lists units of
    channels and the unit does not measure the quantity.
    """
    number, text = line
    channels = _cells_that_are_units(text) if _SPEAKS_OF_UNITS.search(text) else []
    for unit in (*_units_in_words(text), *channels):
        is_of_channel = unit in channels and not measures(unit, "time")
        for quantity in SI_UNIT:
            is_si = measures(unit, quantity) and to_si_factor(unit, quantity) == 1.0
            if not is_si and (measures(unit, quantity) or (is_of_channel and quantity != "time")):
                for column in found:
                    column.doubts.setdefault(quantity, f'line {number} says "{unit}"')


def _cells_that_are_units(text: str) -> list[str]:
    return [cell.strip() for cell in _split_at_marks(text) if _is_listed(cell.strip()) and is_unit(cell.strip())]


def _units_in_words(text: str) -> list[str]:
    """Return the units of a line without those of numbers, as in ``range 200 mNm`` or ``Duration [min]: 5``."""
    alone = bare_unit(text)
    found = [alone] if _is_short(alone) and _is_listed(alone) else []
    for match in _ANYWHERE.finditer(text):
        is_value = match["word"] and re.search(r"\d\s*$", text[: match.start()])
        if not is_value and not _VALUE.match(text, match.end()):
            unit = unit_within(match["word"], "torque") if match["word"] else _unit_of(match)
            found += [unit] if unit else []
    return found


def doubts_of_name(name: str) -> dict[str, str]:
    """Return doubts by quantity if a name ends in a unit without brackets, as in ``Zeit in ms``.

    Examples
    --------
    >>> doubts_of_name("Zeit in ms")["torque"], doubts_of_name("plug in")
    ('its name says "ms"', {})
    """
    found = re.fullmatch(r".*\S\s+(?:in|en)\s+(\S+(?: \S+)?)\s*", name)
    unit = found[1] if found and split_header(name)[1] is None else None
    if unit is None or not (_is_listed(unit) and is_unit(unit)):
        return {}
    return {q: f'its name says "{unit}"' for q in SI_UNIT if not (measures(unit, q) and to_si_factor(unit, q) == 1.0)}
