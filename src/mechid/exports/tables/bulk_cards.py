"""Nastran bulk data cards for frequency response, in fixed fields.

Small fields have 8 columns; large ones have 16, four per line. MSC Nastran, Quick Reference Guide, entries
DAREA, RLOAD1, RLOAD2, TABLED1; Simcenter and Altair read the same format.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from textwrap import wrap

SMALL, LARGE = 8, 16
COMMENT = 72
"""Width of a comment line in columns."""
EDGE = 1e-3
"""Relative distance over which a table falls to 0 beyond its ends."""


def comment(text: str) -> Iterator[str]:
    """Yield a text as comment lines."""
    for line in wrap(text, COMMENT - 2) or [""]:
        yield f"$ {line}".rstrip() + "\n"


def darea(load: int, node: int, component: int, scale: float) -> str:
    """Return the card for location and scale factor of a dynamic load."""
    return _small("DAREA", load, node, component, scale)


def rload1(load: int, area: int, real: int, imaginary: int) -> str:
    """Return the card of a load over frequency, given by tables of real and imaginary part."""
    return _small("RLOAD1", load, area, "", "", real, imaginary)


def rload2(load: int, area: int, amplitude: int) -> str:
    """Return the card of a load over frequency, given by a table of its amplitude at phase 0."""
    return _small("RLOAD2", load, area, "", "", amplitude)


def tabled1(table: int, x: Sequence[float], y: Sequence[float]) -> Iterator[str]:
    """Yield a table of y over ascending x, interpolated linearly and 0 outside, in large fields."""
    # Nastran extrapolates from the last two points, so two zeros at each end keep the table at 0.
    ends = [x[0] * (1.0 - EDGE * k) for k in (2, 1)], [x[-1] * (1.0 + EDGE * k) for k in (1, 2)]
    pairs = [*zip([*ends[0], *x, *ends[1]], [0.0, 0.0, *y, 0.0, 0.0], strict=True)]
    fields = [number for pair in pairs for number in map(_large, pair)] + ["ENDT"]
    yield f"{'TABLED1*':<{SMALL}}{table:>{LARGE}}{'LINEAR':>{LARGE}}{'LINEAR':>{LARGE}}\n"
    yield "*\n"
    for start in range(0, len(fields), 4):
        yield f"{'*':<{SMALL}}" + "".join(f"{field:>{LARGE}}" for field in fields[start : start + 4]) + "\n"


def _small(name: str, *values: int | float | str) -> str:
    fields = [f"{_short(value):<{SMALL}}" for value in (name, *values)]
    return "".join(fields).rstrip() + "\n"


def _short(value: int | float | str) -> str:
    """Return a value in at most eight characters; real numbers have a decimal point."""
    if not isinstance(value, float):
        return str(value)
    # Fewer digits until the number fits into a field of eight columns.
    for digits in range(6, -1, -1):
        # Nastran reads an exponent without its letter, as 1.5+3, which saves columns.
        text = f"{value:#.{digits + 1}g}".replace("e+0", "+").replace("e-0", "-").replace("e", "")
        if len(text) <= SMALL:
            break
    plain = text.rstrip("0")
    return f"{plain}0" if plain.endswith(".") and plain != text else text


def _large(value: float) -> str:
    # A sign, ten digits, the point and the exponent fill 16 columns.
    return f"{value:.9E}"
