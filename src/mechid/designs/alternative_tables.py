"""Sentences and table on alternative explanations: the records that separate them and the expected difference."""

from __future__ import annotations

from mechid.ink.data import Data
from mechid.ink.digits import plain
from mechid.ink.table import Table
from mechid.ink.text_table import Column

PAIRS = (
    Column("if true", "if_true", words=True),
    Column("against", "against", words=True),
    Column("chi-square now", "now"),
    Column("after", "expected"),
    Column("first order", "first_order"),
    Column("look in", "record", words=True),
    Column("differ mN m RMS", "differ"),
    Column("most at Hz", "hz"),
)
SAME = 1.0
"""Chi-square below which two alternatives cannot be distinguished."""


def chi_text(value: float | None) -> str:
    """Return a chi-square as text, without decimals from 10 up.

    Examples
    --------
    >>> chi_text(11266.2), chi_text(61.3), chi_text(3.318e-5), chi_text(None)
    ('11266', '61', '3.3e-05', '-')
    """
    return plain(value, 2) if value is None or abs(value) < 10.0 else f"{value:.0f}"


def rival_lines(data: Data) -> list[str]:
    """Return one or two sentences per group of alternatives."""
    return [f"{' or '.join(group['names'])}: {_words(data, group)}" for group in data["rivals"] or ()]


def _words(data: Data, group: Data) -> str:
    needed = chi_text(group["needed"])
    if group["told_already"]:
        best = min(group["now"], key=lambda name: group["now"][name])
        others = ", ".join(f"{name} by {chi_text(x)}" for name, x in group["now"].items() if name != best)
        return (
            f"the records that there are tell already: fitted from the optima of the others, {best} explains them "
            f"best, and the chi-square of the others is larger: {others}. No record is proposed for it."
        )
    if not group["records"]:
        return _unresolved_words(data, group, needed)
    drive = f"drive {', '.join(group['records'])} ({group['seconds']:.0f} s with what is between records)"
    least = chi_text(group["expected"])
    if not group["clear"]:
        return (
            f"{drive}; but where one is true and the other is fitted to what it makes, the chi-square of the other is "
            f"larger by {least} only, and {needed} are needed to be sure."
        )
    return (
        f"{drive}. Fitted to all records then, the wrong one has a chi-square larger by {least} or more, where "
        f"{needed} are enough to tell."
    )


def _unresolved_words(data: Data, group: Data, needed: str) -> str:
    reach, records = group["farthest"]["expected"], ", ".join(group["farthest"]["records"])
    out = _best_refused(data, group)
    if reach < SAME:
        return (
            "no record of torque that was looked at tells them apart: with all else adjusted, both make the same "
            f"torque (an expected chi-square below {SAME:g}; {needed} are needed). "
            f"Another kind of measurement has to say it{out}."
        )
    farthest = f"{records} would come to {chi_text(reach)}" if records else "no record fits into the test time"
    return (
        f"no records that can be driven tell them apart in {data['limits']['total_s']:.0f} s: {farthest}, where "
        f"{needed} are needed. Give more test time, or other candidates{out}."
    )


def _best_refused(data: Data, group: Data) -> str:
    """Return words on the refused record that would separate the alternatives, empty without one."""
    first = group["names"][0]
    refused = [(c["tells_apart"][first] or 0.0, c) for c in data["candidates"] if c["objection"]]
    if not refused:
        return ""
    reach, best = max(refused, key=lambda pair: pair[0])
    if reach < group["needed"]:
        return ""
    return f". {best['name']} would come to {chi_text(reach)} but is left out: {best['objection']}"


def pair_table(data: Data) -> Table:
    """Return the chi-square between every two alternatives, now and after the chosen records."""
    return Table(PAIRS, pair_rows(data))


def pair_rows(data: Data) -> list[dict[str, str]]:
    """Return one row per ordered pair of alternatives."""
    return [
        {
            "if_true": pair["if_true"],
            "against": pair["against"],
            "now": chi_text(pair["now"]),
            "expected": chi_text(pair["expected"]),
            "first_order": chi_text(pair["first_order"]),
            "record": pair["record"] or "-",
            "differ": "-" if pair["differ_rms_Nm"] is None else plain(1e3 * pair["differ_rms_Nm"], 2),
            "hz": plain(pair["differ_most_hz"], 2),
        }
        for group in data["rivals"] or ()
        for pair in group["pairs"]
    ]
