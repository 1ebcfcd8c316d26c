"""What a column is called by the programs that write it: a torque, the time, a count of samples."""

from __future__ import annotations

import re

from mechid.records.table import Column

TORQUE = re.compile(r"torque|moment|\bm[xyz]\b", re.IGNORECASE)
"""What programs call a torque, in English, German (Drehmoment, Moment) and French (moment)."""
COUNTER = re.compile(
    r"#|[nk]|(no|nr)\.?|idx|index|count(er)?|id|(sample|scan|row|line|point)s?"
    r"|(sample|scan|row|line|point|record|data|messwert)s?[\s_-]*(no|nr|num|number|index|idx|count(er)?|id|n|#)\.?",
    re.IGNORECASE,
)
"""What programs call a column that counts samples."""


def is_torque(column: Column) -> bool:
    """Whether a column is called a torque."""
    return TORQUE.search(column.bare_name) is not None


def is_time(column: Column) -> bool:
    """Whether a column is called so."""
    name = column.bare_name.lower()
    return name in ("t", "tout") or name.startswith("time")  # tout: of a Simulink run


def is_counter(column: Column) -> bool:
    """Whether a column is called what counts samples, and no unit says that it is something else."""
    name = column.bare_name.strip()
    return bool(name) and column.stated_unit is None and COUNTER.fullmatch(name) is not None
