"""The tables of a fleet, each built once for terminal and page."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from markupsafe import Markup

from mechid.ink.data import Data
from mechid.ink.table import Table
from mechid.ink.text_table import PAGE, TERMINAL, Column, OnPage, Row, cell_of

NAME = Column("parameter", "name", words=True)
CHANCE = Column("q", "q")


def _linked(row: Row) -> str:
    """Return a campaign's label, which leads to its report where it has one."""
    if row["link"] is None:
        return str(row["label"])
    return Markup('<a href="{}">{}</a>').format(row["link"], row["label"])


def _with_unit(row: Row) -> Markup:
    unit = row["text"]["unit"]
    more = Markup(' <span class="soft">{}</span>').format(unit) if unit else ""
    return Markup("{}{}").format(row["key"], more)


def _below(text: str, more: str) -> Markup:
    """Return a text with more of it in small letters below."""
    small = Markup('<span class="range">{}</span>').format(more) if more else Markup("")
    return Markup("<span>{}{}</span>").format(text, small)


def _mean(row: Row) -> Markup:
    """Return mean with error and where on a trend that is, or why there is no mean."""
    text = row["text"]
    if row["lacking"]:
        return _below(text["mean"], f"{text['lacking']} term: see by unit")
    return _below(_sure(text, "mean", "std_error"), text["along"])


def _spread(row: Row) -> Markup:
    ends = row["text"]["spread95"]
    return _below(row["text"]["spread"], "" if row["mean"] is None else ends)


def _sure(text: Data, value: str, error: str, unit: str = "") -> str:
    """Return a value with its error and unit, what is empty left out."""
    sigma = f" ± {text[error]}" if text[error] else ""
    return f"{text[value]}{sigma} {text.get(unit, '')}".rstrip()


def _of(value: str, unit: str) -> OnPage:
    return OnPage(ink=lambda row: _sure(row["text"], value, "error", unit))


def _found(key: str) -> OnPage:
    return OnPage(style=lambda row: "word found" if row[key] else "word")


STANDS_OFF = Column("stands off", "outliers", words=True, style="yellow", on_page=_found("outliers"))
FLEET = (
    Column("units", "units"),
    Column("mean", "mean", where=(TERMINAL,)),
    Column("+- sigma", "std_error", where=(TERMINAL,)),
    Column("mean ± σ", "mean", where=(PAGE,), on_page=OnPage(ink=_mean, style="estimate")),
    Column("unit", "unit", words=True, where=(TERMINAL,)),
)
SPREAD = (
    Column("spread", "spread", where=(TERMINAL,)),
    Column("95 %", "spread95", where=(TERMINAL,)),
    Column("spread (95 %)", "spread", where=(PAGE,), on_page=OnPage(ink=_spread)),
    Column("a further unit", "next95", where=(PAGE,)),
    Column("", "differs", words=True, said="differs", on_page=_found("differs")),
    Column("q", "q", where=(PAGE,)),
    STANDS_OFF,
    Column("", "lacking", words=True, where=(TERMINAL,)),
)
PARAMETER = Column("parameter", "key", words=True, on_page=OnPage(ink=_with_unit))
TRENDS = (
    Column("over", "covariate", words=True),
    Column("slope ± σ", "slope", on_page=_of("slope", "unit")),
    Column("95 %", "range"),
    Column("of", "of", words=True),
)
GROUPS = (Column("unit", "unit", words=True), Column("means ± σ", "means", words=True))
MEAN_CHANGES = (
    Column("from, to", "states", words=True),
    Column("units", "units"),
    Column("mean ± σ", "mean", on_page=_of("mean", "unit_of_value")),
    Column("95 %", "range"),
    Column("spread", "spread"),
)
CHANGES = (
    Column("unit", "unit", words=True),
    Column("from, to", "states", words=True),
    Column("change ± σ", "difference", on_page=_of("difference", "unit_of_value")),
    Column("in its errors", "sigmas"),
)
TESTS = {"trends": TRENDS, "groups": GROUPS, "mean_changes": MEAN_CHANGES, "changes": CHANGES}


def campaign_table(data: Data) -> Table:
    """Return the campaigns: whose they are, their grade, and how each estimate came about."""
    has = data["has"]
    return Table(
        (
            Column("campaign", "label", words=True, on_page=OnPage(ink=_linked)),
            *(Column(key, key, words=True, where=(TERMINAL, *([PAGE] if has[key] else []))) for key in has),
            *(Column(name, f"covariate_{k}", where=(PAGE,)) for k, name in enumerate(data["covariates"])),
            Column("grade", "grade", words=True, on_page=OnPage(style=_grade_of(data["failed"]))),
            Column("", "how_words", words=True, said="estimate", on_page=OnPage(ink=_how)),
            Column("took s", "seconds", said="took, s"),
            Column("reason", "reason", words=True, where=(PAGE,), on_page=OnPage(style="word reason", wide=True)),
        ),
        data["campaigns"],
    )


def _grade_of(failed: Sequence[str]) -> Callable[[Row], str]:
    return lambda row: "word failed" if row["label"] in failed else "word"


def _how(row: Row) -> str:
    return cell_of(row, "how_words") + cell_of(row, "said")


def parameter_table(data: Data) -> Table:
    """Return mean and spread of each parameter over the units."""
    narrower = (((PARAMETER, *_on_terminal(FLEET)), (PARAMETER, *_on_terminal(SPREAD))),)
    return Table((PARAMETER, *FLEET, *SPREAD), data["parameters"], group="", narrower=narrower)


def _on_terminal(columns: Sequence[Column]) -> tuple[Column, ...]:
    return tuple(c for c in columns if TERMINAL in c.where)


def tests_table(name: str, rows: Sequence[Row]) -> Table:
    """Return tests of one of the kinds of `TESTS`: trends, groups, changes."""
    return Table((NAME, *TESTS[name], CHANCE), rows)
