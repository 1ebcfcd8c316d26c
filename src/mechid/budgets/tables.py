"""Tables of a budget."""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup

from mechid.budgets.texts import NO_NUMBER
from mechid.ink.data import Data
from mechid.ink.document import IN_DOCUMENTS
from mechid.ink.table import Table
from mechid.ink.text_table import DOCX, MARKDOWN, PAGE, TERMINAL, Column, OnPage, Row, cell_of

TEXTS, NARROW_TEXTS = (TERMINAL, MARKDOWN, DOCX), (TERMINAL, MARKDOWN)
"""Printers of texts; `NARROW_TEXTS` leaves out the paper, which has no room for all columns."""
WIDE = "word shares"
"""Style of cells on a page that list parameters."""


def _below(text: str, *more: str) -> Markup:
    """Return a text with further lines in small letters below."""
    lines = Markup("").join(Markup('<span class="range">{}</span>').format(line) for line in more)
    return Markup("<span>{} {}</span>").format(text, lines)


def _with_range(key: str, header: str = "") -> OnPage:
    """Return the display on a page of a cell whose text has a range in brackets."""

    def ink(row: Row) -> Markup:
        text, bracket, more = row["text"][key].partition(" (")
        return _below(text, bracket.strip() + more) if bracket else Markup("<span>{}</span>").format(text)

    return OnPage(ink=ink, header=header)


def _level_with_error(row: Row) -> Markup:
    """Return a level with its error, and the sampling part of the error."""
    text = row["text"]
    level = f"{text['level']} ± {text['sigma']}" if text["sigma"] else text["level"]
    if not row["decided"]["sampling_sigma_rad"]:
        return Markup("<span>{}</span>").format(level)
    return _below(level, f"(± {text['sampling']} by draws)")


def _deciding_margin(row: Row) -> Markup:
    """Return the deciding number, and below it the coupling and the margin with its interval."""
    text = row["text"]
    margin = text["two_way_margin" if text["coupling"] == "two-way" else "one_way_margin"]
    return _below(text["deciding"], text["coupling"], margin)


def _spread(row: Row) -> str:
    return f"{row['text']['worst_member']}{row['text']['spread']}"


def _index(row: Row) -> str:
    return f"{row['text']['index']}, {row['axis']}; {row['text']['statistics']}"


NAME, MODE = Column("requirement", "requirement", words=True), Column("mode", "mode", words=True)
VERDICT = Column(
    "verdict", "met", words=True, on_page=OnPage(style=lambda r: "word " + r["text"]["met"].replace(" ", "-"))
)
REQUIREMENTS = (
    VERDICT,
    NAME,
    MODE,
    Column("index", "index", words=True, where=TEXTS),
    Column("axis", "axis", words=True, where=TEXTS),
    Column(
        "index", "index", words=True, where=(PAGE,), on_page=OnPage(ink=_index, tip=lambda r: str(r["index_words"]))
    ),
    Column("statistics", "statistics", words=True, where=(MARKDOWN,)),
    Column("at, steps/s", "rate", where=IN_DOCUMENTS),
    Column("level rad", "level", said="level, rad", where=TEXTS),
    Column("+- sigma", "sigma", said="± σ", where=TEXTS),
    Column("level ± σ, rad", "level", where=(PAGE,), on_page=OnPage(ink=_level_with_error)),
    Column("by draws", "sampling", said="of it by draws", where=NARROW_TEXTS),
    Column("lacking rad", "lacking", said="of it lacking in the model (of the limit)", where=NARROW_TEXTS),
    Column("limit rad", "limit", said="limit, rad"),
    Column(
        "decides %",
        "deciding",
        style="bold",
        said="decides, %",
        strong=True,
        on_page=OnPage(ink=_deciding_margin, style="estimate"),
    ),
    Column("of", "coupling", words=True, said="coupling that decides", where=TEXTS),
    Column("two-way %", "two_way_margin", said="two-way margin, %", where=TEXTS),
    Column("one-way %", "one_way_margin", said="one-way margin, %", on_page=_with_range("one_way_margin")),
    Column("by ECSS sum", "ecss", said="ECSS sum, one-way", where=NARROW_TEXTS),
)
SHARES = (
    NAME,
    MODE,
    Column("band", "shares", words=True, on_page=OnPage(style=WIDE)),
    Column("ensemble", "spread", words=True, on_page=OnPage(ink=_spread, style=WIDE)),
    Column("one-way level, rad", "one_way"),
    Column("nominal unit one-way, rad", "nominal"),
    Column("nominal unit two-way, rad", "two_way"),
    Column("ECSS sum one-way, rad", "ecss"),
    Column("other sources, rad", "others"),
    Column("lacking in the model, rad (of the limit)", "lacking", on_page=_with_range("lacking", "lacking, rad")),
)
MODES = (
    Column("mode", "name", words=True),
    Column("worst rate", "worst_rate", said="largest one-way RMS at, steps/s"),
    Column("torque RMS N m", "torque", said="torque RMS, N m"),
    Column("one-way RMS rad", "one_way", said="line of sight RMS one-way, rad"),
    Column("lacking", "lacking", said="lacking in the model, one-way, rad"),
    Column("two-way RMS rad", "two_way", said="line of sight RMS two-way, rad"),
    Column("|R K|", "gain", said="largest |R K|"),
    Column("slowest transient, to 1/e", "slowest", where=IN_DOCUMENTS),
)
STEADY = (
    Column("rate, steps/s", "rate"),
    Column("reached from", "reached", words=True),
    Column("repeats", "repeats", words=True),
    Column("largest multiplier", "multiplier"),
    Column("decay, s", "decay"),
    Column("follows", "follows", words=True),
    Column("torque RMS, N m", "torque"),
    Column("line of sight RMS, rad", "rms"),
    Column("", "counts", words=True),
)
EMISSION = (
    Column("Hz", "hz"),
    Column("at, steps/s", "rate"),
    Column("model, RMS N m", "modelled"),
    Column("lacking, RMS N m", "residual"),
    Column("95 % bound, RMS N m", "bound"),
)
NAMED = (
    Column("line", "name", words=True),
    Column("cause", "words", words=True),
    Column("order", "order"),
    Column("Hz", "hz"),
    Column("model, N m", "torque"),
    Column("lacking, N m", "residual"),
    Column("95 % bound, N m", "bound"),
    Column("line of sight, rad", "rms"),
)
SIDE = (
    Column("", "name", words=True),
    Column("with phase", "coherent", said="lines with a phase to the torque"),
    Column("by magnitude", "magnitude"),
    Column("line of sight RMS rad", "rms", words=True, said="line of sight RMS by itself, rad"),
)
CROSSINGS = (
    Column("rate, steps/s", "rate"),
    Column("order", "order"),
    Column("mode", "mode", words=True),
    Column("frequency, Hz", "frequency"),
)


def requirement_table(data: Data) -> Table:
    """Return each requirement's level, limit and margins at its worst rate."""
    return Table(REQUIREMENTS, data["requirements"])


def share_table(data: Data) -> Table:
    """Return the parameters that drive each margin, and the levels that do not decide."""
    return Table(SHARES, data["requirements"])


def mode_table(data: Data) -> Table:
    """Return the modes of operation, at the rate of the largest line-of-sight RMS."""
    return Table(MODES, data["modes"])


def mode_facts(mode: Data) -> list[tuple[str, str]]:
    """Return the known values of a mode's row in `mode_table`, with their names."""
    pairs = [(column.label, cell_of(mode, column.key)) for column in MODES[1:]]
    return [(name, value) for name, value in pairs if value != NO_NUMBER]


def steady_table(mode: Data) -> Table:
    """Return the steady states of a mode at rates with several, or with an unusual one."""
    return Table(STEADY, mode["steady_rows"])


def emission_table(mode: Data) -> Table:
    """Return the torque of a mode on the base by third octave."""
    return Table(EMISSION, mode["emission_rows"])


def named_table(mode: Data) -> Table:
    """Return the lines of a mode at orders that the mechanism names."""
    return Table(NAMED, mode["named_rows"])


def side_table(mode: Data) -> Table:
    """Return the line-of-sight RMS of a mode from the torque and from each other component."""
    return Table(SIDE, mode["side_rows"])


def crossing_table(crossings: Sequence[Data]) -> Table:
    """Return the rates at which orders of the step rate cross modes."""
    rows = [
        {
            "rate": f"{c['rate']:.4g}",
            "order": f"{c['order']:g}",
            "mode": c["mode"],
            "frequency": f"{c['frequency_hz']:.4g}",
        }
        for c in crossings
    ]
    return Table(CROSSINGS, rows)


EXPORTED = (
    Column("requirement", "name", words=True),
    Column("direction", "direction", words=True),
    Column("mode", "mode", words=True),
    Column("rate, steps/s", "rate"),
    Column("frequency, Hz", "frequency"),
    Column("value", "value"),
    Column("bounds", "bounds"),
    Column("limit", "limit"),
    Column("unit", "unit", words=True),
    Column("margin, dB", "margin"),
    Column("verdict", "verdict", words=True, strong=True),
)
EXPORTED_NARROW = (*(column for column in EXPORTED if column.key not in ("bounds", "unit", "direction")),)


def emission_requirement_table(rows: Sequence[Row]) -> Table:
    """Return the table of the requirements on the torque at the interface."""
    return Table(EXPORTED, rows, narrower=((EXPORTED_NARROW,),))
