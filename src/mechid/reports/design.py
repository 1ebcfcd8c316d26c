"""A design on a terminal, as Markdown and as files; its numbers are those of design.json."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from mechid.campaign.mechanism_text import mechanism_text
from mechid.campaign.templates import MECHANISM_NAME
from mechid.designs.design import Design
from mechid.designs.hand_off import design_data, rate_rows
from mechid.designs.proposal import criterion_words, has_file, proposed_campaign, proposed_options
from mechid.errors import UsageError
from mechid.identification.result.estimate_file import json_text
from mechid.reports.design_figures import design_figures
from mechid.reports.digits import plain
from mechid.reports.figures import write_figures
from mechid.reports.markdown_text import bullets, table
from mechid.reports.rivals import PAIRS, pair_rows, rival_lines
from mechid.reports.sheet import FOLDER_NAME
from mechid.reports.terminal import print_lines, say
from mechid.reports.text_table import Column, print_table
from mechid.writing import writable, write_together

JSON, MARKDOWN, CAMPAIGN, OPTIONS, RATES = (
    "design.json",
    "design.md",
    "campaign.toml",
    "design.toml",
    "torque_over_rate.csv",
)
RECORDS = (
    Column("chosen record", "name", words=True),
    Column("s", "seconds"),
    Column("peak N m", "peak"),
    Column("sigma falls by", "gain"),
    Column("voltage margin %", "voltage"),
    Column("torque margin N m", "torque"),
)
LOSSES = (
    Column("stepping", "stepping", words=True),
    Column("changed", "changed", words=True),
    Column("pull-in steps/s", "pull_in"),
    Column("pull-out steps/s", "pull_out"),
)
RIVALS = "Effects that the records so far cannot tell apart"
SHOWN_PEAKS, SHOWN_OBJECTIONS, SHOWN_RANGES = 4, 12, 3
Row = Mapping[str, Any]


def write_design(design: Design, folder: Path | str, data: Mapping[str, Any] | None = None) -> list[Path]:
    """Write design.json, design.md, the proposed campaign, torque over rate and figures; return the files.

    `data` is what `design_data` made, where it is at hand.

    Raises
    ------
    UsageError
        The folder cannot be written to, or holds the campaign itself.
    """
    folder = Path(folder)
    refuse_own_folder(design.campaign.path, folder)
    data = design_data(design) if data is None else data
    texts = {
        JSON: json_text(data),
        MARKDOWN: design_markdown(data),
        CAMPAIGN: proposed_campaign(design, data, folder),
        OPTIONS: proposed_options(design),
        **({} if has_file(design) else {MECHANISM_NAME: mechanism_text(design.campaign.mechanism)}),
        RATES: "".join(rate_rows(data)),
    }
    files = write_together(folder, texts)
    with writable(folder):
        write_figures(design_figures(data).items(), folder / FOLDER_NAME)
    return [*files, folder / FOLDER_NAME]


def refuse_own_folder(campaign: Path, folder: Path) -> None:
    """Raise UsageError where the proposal would replace the campaign file that it is made from."""
    if folder.resolve() == campaign.parent.resolve():
        raise UsageError(f"{folder}: holds the campaign itself, which must not be replaced; give another folder")


def print_design(data: Row, console: Console, files: Sequence[Path] = ()) -> None:
    """Print what `design_data` made, and where the files are."""
    say(console, headline(data), "bold")
    console.print()
    if data["rivals"]:
        say(console, RIVALS, "bold")
        for line in rival_lines(data):
            say(console, line)
        print_table(console, PAIRS, [{"text": {}, **row} for row in pair_rows(data)])
    say(console, "Standard errors: at the values believed, and the median over the mechanisms that may be true", "bold")
    print_table(console, _columns(data), [{"text": {}, **row} for row in _parameter_rows(data)])
    print_table(console, RECORDS, [{"text": {}, **row} for row in _record_rows(data)])
    say(console, "Step loss", "bold")
    say(console, loss_words(data))
    print_table(console, LOSSES, [{"text": {}, **row} for row in _loss_rows(data)])
    print_lines(console, "holes", hole_lines(data))
    print_lines(console, "amplitude", peak_lines(data))
    print_lines(console, "left out", _left_out(data))
    print_lines(console, "warning", data["warnings"], "yellow")
    print_lines(console, "written", [str(path) for path in files])


def _columns(data: Row) -> tuple[Column, ...]:
    """Return the columns of the parameters; after a fit they are compared with what is known now."""
    before, many = ("now", "of its draws") if data["after_fit"] else ("planned", "over the prior")
    return (
        Column("parameter", "name", words=True),
        Column("value", "value"),
        Column("unit", "unit", words=True),
        Column(f"sigma {before}", "planned"),
        Column("chosen", "chosen"),
        Column("better by", "gain"),
        Column(f"{many}: {before}", "planned_spread"),
        Column("chosen", "chosen_spread"),
    )


def headline(data: Row) -> str:
    """Return the result in a sentence."""
    chosen = data["chosen"]
    count = len(chosen["records"])
    of = f"{count} record{'s' * (count != 1)} in {chosen['seconds']:.0f} s"
    by = criterion_words(data)
    if data["after_fit"]:
        return f"What to measure next, by {by}: {of} make standard errors {data['gain_factor']:.3g} times smaller."
    planned = data["planned"]
    return (
        f"By {by}, over {data['mechanisms']} mechanisms that may be true: {of} make standard errors "
        f"{data['gain_factor']:.3g} times smaller than the {len(planned['records'])} planned "
        f"in {planned['seconds']:.0f} s."
    )


def design_markdown(data: Row) -> str:
    """Return the design's tables as Markdown."""
    parts = ["# Design of the next test", f"**{headline(data)}**", "## Standard errors"]
    if data["rivals"]:
        cells = [[row[c.key] for c in PAIRS] for row in pair_rows(data)]
        parts[2:2] = [f"## {RIVALS}", bullets(rival_lines(data)), table([c.header for c in PAIRS], cells)]
    for title, columns, rows in (
        ("", _columns(data), _parameter_rows(data)),
        ("## Records, the most informative first", RECORDS, _record_rows(data)),
        ("## Step loss", LOSSES, _loss_rows(data)),
    ):
        parts += [title] if title else []
        parts += [loss_words(data)] if columns is LOSSES else []
        parts.append(table([c.header for c in columns], [[row[c.key] for c in columns] for row in rows]))
    for title, lines in (
        ("Rates at which steps are lost though higher ones hold", hole_lines(data)),
        ("Torque over the step rate", peak_lines(data)),
        ("Left out", _left_out(data)),
        ("Warnings", data["warnings"]),
    ):
        parts += [f"## {title}", bullets(lines)] if lines else []
    return "\n\n".join(parts) + "\n"


def _parameter_rows(data: Row) -> list[dict[str, str]]:
    return [
        {
            "name": p["name"],
            "value": plain(p["value"]),
            "unit": p["unit"],
            "planned": _sigma(p["planned"], p["planned_reason"]),
            "chosen": _sigma(p["chosen"], p["chosen_reason"]),
            "gain": plain(p["planned"] / p["chosen"], 2) if p["planned"] and p["chosen"] else "-",
            "planned_spread": plain(p["planned_spread"][0], 2),
            "chosen_spread": plain(p["chosen_spread"][0], 2),
        }
        for p in data["parameters"]
    ]


def _sigma(sigma: float | None, reason: str) -> str:
    return reason or plain(sigma, 2)


def _record_rows(data: Row) -> list[dict[str, str]]:
    peaks = {c["name"]: c["peak_torque_Nm"] for c in data["candidates"]}
    steps = zip(data["trail"][:-1], data["trail"][1:], strict=True)
    return [
        _record_row(
            r["name"], r["duration_s"], peaks.get(r["name"]), before - after, data["margins"].get(r["name"], {})
        )
        for r, (before, after) in zip(data["chosen"]["records"], steps, strict=True)
    ]


def _record_row(name: str, seconds: float, peak: float | None, gain: float, margin: Row) -> dict[str, str]:
    voltage = margin.get("voltage")
    return {
        "name": name,
        "seconds": f"{seconds:g}",
        "peak": plain(peak, 2),
        "gain": f"{-100.0 * math.expm1(-gain):.1f} %",
        "voltage": "-" if voltage is None else f"{100.0 * voltage:.0f}",
        "torque": plain(margin.get("torque_Nm"), 2),
    }


def _loss_rows(data: Row) -> list[dict[str, str]]:
    return [
        {
            "stepping": row["stepping"],
            "changed": _changed(row),
            "pull_in": limit_words(row["pull_in"]),
            "pull_out": limit_words(row["pull_out"]),
        }
        for row in data["step_loss"]
    ]


def _changed(row: Row) -> str:
    if not row["changed"]:
        return "as believed"
    if row["changed"] == "friction torque":
        return f"{plain(row['to'], 2)} N m more friction"
    return f"{row['changed']} x {row['to']:g}"


def limit_words(limit: Row) -> str:
    """Return where a stepping holds: "354", or "118, 147 to 1107" with a hole between."""
    low, high = limit["searched"]
    least = None if limit["brought_from"] else low
    ranges = [_range(first, last, least, high) for first, last in limit["ranges"]]
    if len(ranges) > SHOWN_RANGES:
        ranges[1:-1] = [f"{len(ranges) - 2} more"]
    return ", ".join(ranges) or "none"


def _range(first: float, last: float, least: float | None, highest: float) -> str:
    end = f"{last:.0f}" if last < highest else f"> {last:.0f}"
    return end if first == least else f"{first:.0f} to {end}"


def loss_words(data: Row) -> str:
    """Say how the table of step loss is to be read, and how closely was looked."""
    low, high = data["step_loss"][0]["pull_in"]["searched"]
    search = data["step_loss_search"]
    far, near, slow = (f"{100.0 * (search[f'{key}_ratio'] - 1.0):.0f} %" for key in ("far", "near", "slow"))
    return (
        f"Pull-in: the rates at which the motor starts and stops at once. Pull-out: those that it follows once brought "
        f"there slowly, from rest or, above a hole, from the rate that a range begins with. A single number is the end "
        f"of all rates from {low:g} steps/s on; > {high:g} is beyond what was looked at. Between two ranges is a hole, "
        f"in which steps are lost to a resonance. Starts were tried every {far}, near resonances every {near} but no "
        f"closer than {search['least_steps_per_s']:g} step/s; slow ones every {slow}: a narrower hole may have been "
        "missed."
    )


def hole_lines(data: Row) -> list[str]:
    """Return, at the values believed, where each stepping loses steps though it holds at higher rates."""
    return [
        f"{row['stepping']} stepping, {words}: "
        + ", ".join(f"{first:.0f} to {last:.0f}" for first, last in row[key]["holes"])
        + f" steps/s; {_beyond(row[key])}"
        for row in data["step_loss"]
        for key, words in (("pull_in", "started at once"), ("pull_out", "brought there slowly"))
        if row[key]["holes"] and not row["changed"]
    ]


def _beyond(limit: Row) -> str:
    if limit["limit"] is None:
        return f"above, it holds to the highest rate looked at, {limit['searched'][1]:.0f} steps/s"
    return f"above {limit['limit']:.0f} steps/s it holds nowhere up to {limit['searched'][1]:.0f}"


def peak_lines(data: Row) -> list[str]:
    """Return where each stepping's torque is largest."""
    return [
        f"{m['stepping']} stepping: largest at "
        + ", ".join(f"{p['rate']:.3g} steps/s ({p['amplitude_Nm']:.2g} N m)" for p in m["peaks"][:SHOWN_PEAKS])
        for m in data["torque_over_rate"]
        if m["peaks"]
    ]


def _left_out(data: Row) -> list[str]:
    lines = [f"{c['name']}: {c['objection']}" for c in data["candidates"] if c["objection"]]
    more = len(lines) - SHOWN_OBJECTIONS
    return [*lines[:SHOWN_OBJECTIONS], f"and {more} more, which stand in {JSON}"] if more > 0 else lines
