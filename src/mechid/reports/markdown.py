"""The report's tables as Markdown, to be pasted into a document."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from mechid.reports.path import COMPLETED_TITLE, HEADER, cells
from mechid.reports.quantities import quantity_words, torque_alone
from mechid.reports.side import SIDE_COLUMNS, SIDE_SAID, SIDE_TITLE

Row = Sequence[str]
PARAMETER = ("parameter", "symbol", "nominal", "estimate", "± σ", "unit", "min", "max", "status")
ORDER = ("record", "order", "measured, N m", "modelled, N m", "error, %", "phase, deg", "largest at, steps/s")
CHANNEL_ORDER = ("record", "channel", "unit", "order", "measured", "modelled", *ORDER[4:])
OWN = ("name", "value", "standard error", "unit")
STAGE = ("stage", "records", "record time, s", "free", "cost, σ²", "evaluations", "took, s")


def report_markdown(data: Mapping[str, Any]) -> str:
    """Return verdict and tables of what `report_contents` made."""
    summary = data["summary"]
    parts = [f"# {cell(data['title'])}", f"**{summary['headline']}**"]
    if data["synthetic"]:
        parts.append("**Synthetic**: the records were simulated; nothing of this was measured.")
    for each in summary["questions"]:
        parts += [f"## {each['question']}", bullets(each["answers"])]
    parts += ["## Parameters", table(PARAMETER, map(_parameter, _estimated(data)))]
    parts += ["## Known values", table((*PARAMETER[:2], "value", "unit"), map(_known, _known_rows(data)))]
    parts += _completed(data["completed"])
    parts += [part for one in data["missing"] for part in _missing(one)]
    parts += _beside(data["beside"])
    parts += ["## Records", _records(data["record_table"])]
    if data["orders"]:
        parts += ["## Orders of the step rate", _orders(data["orders"])]
    if data["side"]:
        rows = ([row["name"] if c.key == "name" else row["text"][c.key] for c in SIDE_COLUMNS] for row in data["side"])
        parts += [f"## {SIDE_TITLE}", SIDE_SAID, table([c.header for c in SIDE_COLUMNS], rows)]
    parts += _channel_information(data["information"])
    parts += ["## Stages", table(STAGE, map(_stage, data["stages"]))]
    for title, lines in (("Warnings", data["warnings"]), ("Notes", data["notes"])):
        if lines:
            parts += [f"## {title}", bullets(lines)]
    inputs = data["provenance"].get("inputs_sha256", {}).items()
    parts += ["## Provenance", table(("", ""), data["origin"]), table(("input", "SHA-256"), inputs)]
    return "\n\n".join(parts) + "\n"


class Strong(str):
    """A text that stands out in its cell."""

    __slots__ = ()


def cell(text: str) -> str:
    r"""Return a text that stays within its cell or line and is not read as markup.

    Examples
    --------
    >>> print(cell("a|b <script> coil_a*"), cell(Strong("2.7")))
    a\|b \<script> coil\_a\* **2.7**
    """
    escaped = "".join(f"\\{c}" if c in "\\|<`*_[]" else c for c in str(text))
    line = " ".join(escaped.split())
    return f"**{line}**" if isinstance(text, Strong) else line


def _missing(one: Mapping[str, Any]) -> list[str]:
    """Return what the files do not declare and the fit has: a heading, its values, what declares it."""
    text = one["text"]
    said = f"Not declared, and the records ask for it: chi-square {text['chi_square']} for {one['dof']}, "
    said += f"{text['share_percent']} % of what they hold beyond noise. To declare it, at the end of `campaign.toml`:"
    heading = f"## Not declared: {cell(one['words'])}"
    return [heading, table(OWN, map(_own, one["rows"])), said, f"```toml\n{one['toml']}```"]


def _completed(completed: Mapping[str, Any] | None) -> list[str]:
    """Return the steps by which the mechanism was completed: a heading, what they are, a table."""
    if completed is None:
        return []
    rows = [table(HEADER, map(cells, completed["rows"]))] if completed["rows"] else []
    return [f"## {COMPLETED_TITLE}", *map(cell, completed["said"]), *rows]


def _beside(beside: Mapping[str, Any] | None) -> list[str]:
    """Return the terms that the fit has beside the mechanism: a heading, what they are, those clear and the others."""
    if not beside:
        return []
    parts = ["## Terms beside the mechanism file", *map(cell, beside["said"])]
    for rows, said in ((beside["clear_terms"], []), (beside["other_terms"], [beside["other_words"]])):
        lines = ((f"{row['words']} ({row['term']})", *_own(row), row["meaning"]) for row in rows)
        parts += [*said, table(("term", *OWN, "meaning"), lines)] if rows else []
    return parts


def _own(row: Mapping[str, Any]) -> Row:
    return (row["name"], *row["text"].values())


def _estimated(data: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return [row for row in data["parameters"] if row["estimated"]]


def _known_rows(data: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return [row for row in data["parameters"] if not row["estimated"]]


def _parameter(row: Mapping[str, Any]) -> Row:
    keys = ("nominal", "estimate", "std_error", "unit", "min", "max", "status")
    return (row["name"], row["symbol"], *(row["text"][key] for key in keys))


def _known(row: Mapping[str, Any]) -> Row:
    return row["name"], row["symbol"], row["text"]["estimate"], row["text"]["unit"]


def _orders(rows: Sequence[Mapping[str, Any]]) -> str:
    keys = ("order", "measured", "modelled", "amplitude_error_percent", "phase_error_deg", "peak_rate")
    named = () if torque_alone(rows) else ("quantity", "unit")
    lines = ((row["name"], *(row["text"][key] for key in (*named, *keys))) for row in rows)
    return table(CHANNEL_ORDER if named else ORDER, lines)


def _channel_information(information: Mapping[str, Any] | None) -> list[str]:
    """Return what each channel adds, where there are several."""
    if not information or len(information["channels"]) < 2:
        return []
    words = [quantity_words(quantity) for quantity in information["channels"]]
    tables = {
        "Share of a channel in what is known of a parameter, percent, all others held:": "channel_share_percent",
        "Factor on a standard error if a channel were not measured:": "without_channel",
    }
    parts = ["## What each channel adds"]
    for said, key in tables.items():
        rows = zip(information["parameters"], information["text"][key], strict=True)
        parts += [said, table(("parameter", *words), ([name, *cells] for name, cells in rows))]
    return parts


def _stage(row: Mapping[str, Any]) -> Row:
    keys = ("records", "record_s", "free", "cost", "evaluations", "seconds")
    return (row["name"], *(row["text"][key] for key in keys))


def _records(rows: Sequence[Mapping[str, Any]]) -> str:
    labels = [label for label, _ in rows[0]["cells"]] if rows else []
    return table(["record", "use", *labels], ([r["name"], r["use"], *(text for _, text in r["cells"])] for r in rows))


def table(header: Sequence[str], rows: Iterable[Row]) -> str:
    """Return a table; its cells are escaped."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(t if t == "---" else cell(t) for t in line) + " |" for line in lines)


def bullets(lines: Iterable[str]) -> str:
    """Return a list of lines."""
    return "\n".join(f"- {cell(line)}" for line in lines)
