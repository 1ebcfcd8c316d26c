"""Recognition of columns by their names: torque, time, and sample counters."""

from __future__ import annotations

import re
from collections.abc import Sequence

from mechid.records.table import Column

TORQUE = re.compile(r"torque|moment|\bm[xyz]\b", re.IGNORECASE)
"""Names of a torque in English, German (Drehmoment, Moment) and French (moment)."""
COUNTER = re.compile(
    r"#|[nk]|(no|nr)\.?|idx|index|count(er)?|id|(sample|scan|row|line|point|frame|entry|obs|observation)s?"
    r"|(sample|scan|row|line|point|record|data|frame|messwert)s?[\s_-]*(no|nr|num|number|index|idx|count(er)?|id|n|#)\.?"
    r"|seq(uence)?([\s_-]*(no|nr|num|number|id|#)\.?)?|unnamed: ?\d+|level_\d+|row[\s_.-]*names?"
    r"|zeile(n(nummer|nr\.?))?|nummer|(lfd|laufende)\.?[\s_-]*(nr|nummer)\.?|messpunkt|messung|datensatz|punkt",
    re.IGNORECASE,
)
"""Names of sample counters, as written by loggers, pandas (``Unnamed: 0``), R and German programs."""


def is_torque(column: Column) -> bool:
    """Return whether a column has the name of a torque."""
    return TORQUE.search(column.bare_name) is not None


def is_time(column: Column) -> bool:
    """Return whether a column has the name of a time."""
    name = column.bare_name.lower()
    # Simulink names it tout.
    return name in ("t", "tout") or name.startswith(("time", "zeit"))


def is_counter(column: Column) -> bool:
    """Return whether a column has the name of a sample counter, and no unit."""
    name = column.bare_name.strip()
    return bool(name) and column.stated_unit is None and COUNTER.fullmatch(name) is not None


def is_row_number(columns: Sequence[Column]) -> bool:
    """Return whether the first column contains row numbers: by its name, or as the only column without a name."""
    # The index of a pandas data frame has no name in a CSV file.
    first, *others = columns
    nameless = not first.key.strip() and first.unit is None and any(column.key for column in others)
    return nameless or is_counter(first)
