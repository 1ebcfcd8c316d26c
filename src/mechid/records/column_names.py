"""Names that programs give to columns: a torque, the time, a count of samples."""

from __future__ import annotations

import re
from collections.abc import Sequence

from mechid.records.table import Column

TORQUE = re.compile(r"torque|moment|\bm[xyz]\b", re.IGNORECASE)
"""Names of a torque, in English, German (Drehmoment, Moment) and French (moment)."""
COUNTER = re.compile(
    r"#|[nk]|(no|nr)\.?|idx|index|count(er)?|id|(sample|scan|row|line|point|frame|entry|obs|observation)s?"
    r"|(sample|scan|row|line|point|record|data|frame|messwert)s?[\s_-]*(no|nr|num|number|index|idx|count(er)?|id|n|#)\.?"
    r"|seq(uence)?([\s_-]*(no|nr|num|number|id|#)\.?)?|unnamed: ?\d+|level_\d+|row[\s_.-]*names?"
    r"|zeile(n(nummer|nr\.?))?|nummer|(lfd|laufende)\.?[\s_-]*(nr|nummer)\.?|messpunkt|messung|datensatz|punkt",
    re.IGNORECASE,
)
"""Names of a column that counts samples, as loggers, pandas (``Unnamed: 0``), R and German programs write them."""


def is_torque(column: Column) -> bool:
    """Whether a column is named as a torque."""
    return TORQUE.search(column.bare_name) is not None


def is_time(column: Column) -> bool:
    """Whether a column is named as the time."""
    name = column.bare_name.lower()
    return name in ("t", "tout") or name.startswith(("time", "zeit"))  # tout: of a Simulink run


def is_counter(column: Column) -> bool:
    """Whether a column is named as a count of samples, and no unit says that it is something else."""
    name = column.bare_name.strip()
    return bool(name) and column.stated_unit is None and COUNTER.fullmatch(name) is not None


def is_row_number(columns: Sequence[Column]) -> bool:
    """Whether the first column counts the rows: named so, or without a name beside columns with names.

    The index of a pandas data frame has no name in a CSV file.
    """
    first, *others = columns
    nameless = not first.key.strip() and first.unit is None and any(column.key for column in others)
    return nameless or is_counter(first)
