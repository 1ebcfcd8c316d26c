"""The report of a fit on a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from mechid.diagnoses.effects_shown import own_table
from mechid.diagnoses.path import COMPLETED_TITLE, path_table
from mechid.identification.result.grade import OF_MECHANISM_FILE
from mechid.ink.console import print_lines, say, say_if_synthetic
from mechid.ink.quantities import torque_alone
from mechid.reports.lacking import LACKING
from mechid.reports.side import SIDE_TITLE
from mechid.reports.tables import (
    followed_table,
    order_table,
    parameter_table,
    prior_table,
    side_table,
    stage_table,
    validation_table,
)
from mechid.reports.use import held_out, left_out

GRADE_STYLE = {"A": "bold green", "B": "bold yellow", "C": "bold red", "failed": "bold red"}
ABOUT_ALL = "all records"
ABOUT_RECORDS = ("record ", "records ")
"""How a warning begins that says whom of the records it concerns."""
HELD_OUT_WORDS = "Prediction of the records held out"
LEFT_OUT_WORDS = "Records to estimate from that were left out, because they contradict the others"


def print_report(data: Mapping[str, Any], console: Console, files: Sequence[Path] = ()) -> None:
    """Print what `report_data` made, and where the files are; what is odd about the user's files comes first."""
    say_if_synthetic(console, data)
    say(console, data["grade_words"], GRADE_STYLE[data["grade"]])
    about_all, about_records, others = _told_apart(data["warnings"])
    of_file, reasons = _file_first(data["reasons"])
    if data["missing"]:
        found = "; ".join(f"{one['name']}: {one['words']}{one['text']['apart']}" for one in data["missing"])
        say(console, f"found, not declared: {found} (below)", "yellow")
    print_lines(console, "warning", about_all, "yellow")
    _print_reasons(of_file, console)
    print_lines(console, "warning", about_records, "yellow")
    _print_reasons(reasons, console)
    if not any(reason["text"].startswith(data["outcome"]["message"]) for reason in data["reasons"]):
        say(console, data["outcome"]["message"])
    console.print()
    legend = "; off: estimate minus truth, in sigmas" if data["has_truth"] else ""
    say(console, f"Parameters{legend}", "bold")
    parameter_table(data).print(console)
    _print_priors(data, console)
    _print_lacking(data["lacking"], console)
    _print_completed(data["completed"], console)
    _print_missing(data, console)
    if torque_alone(data["channels"]):
        say(console, "Records; residual, noise and offset in N m, drift in N m/s", "bold")
    else:
        say(console, "Channels; residual, noise and offset in the unit, drift in the unit a second", "bold")
    followed_table(data).print(console)
    _print_held_out(data, console)
    if data["side"]:
        say(console, f"{SIDE_TITLE}: the largest lines of each component", "bold")
        side_table(data["side"]).print(console)
    say(console, "Stages", "bold")
    stage_table(data["stages"]).print(console)
    if data["arrived"]:
        say(console, data["arrived"])
    print_lines(console, "warning", others, "yellow")
    print_lines(console, "note", data["notes"], "dim")
    print_lines(console, "written", [str(path) for path in files])


def _told_apart(warnings: Sequence[str]) -> tuple[list[str], list[str], list[str]]:
    """Return the warnings about all records, those about some of them, and the others."""
    about_all = [line for line in warnings if line.startswith(ABOUT_ALL)]
    about_records = [line for line in warnings if line.startswith(ABOUT_RECORDS)]
    return about_all, about_records, [line for line in warnings if not line.startswith((ABOUT_ALL, *ABOUT_RECORDS))]


def _file_first(reasons: Sequence[Mapping[str, Any]]) -> tuple[list[Mapping[str, Any]], list[Mapping[str, Any]]]:
    """Return the reasons that stand in the mechanism file, which mostly are why the others are there; and those."""
    of_file = [reason for reason in reasons if reason["cause"] in OF_MECHANISM_FILE]
    return of_file, [reason for reason in reasons if reason not in of_file]


def _print_reasons(reasons: Sequence[Mapping[str, Any]], console: Console) -> None:
    """Print why a fit has no better grade, each with what to do."""
    for reason in reasons:
        print_lines(console, reason["words"], [reason["text"]])
        print_lines(console, "next", [reason["next_command"]])


def _print_completed(completed: Mapping[str, Any] | None, console: Console) -> None:
    """Print the steps by which the mechanism was completed, where that was asked for."""
    if completed is None:
        return
    say(console, COMPLETED_TITLE, "bold")
    for line in completed["said"]:
        say(console, line)
    if completed["rows"]:
        console.print()
        path_table(completed["rows"]).print(console)
    else:
        console.print()


def _print_lacking(lines: Sequence[str], console: Console) -> None:
    """Print what the model is missing; nothing where it lacks nothing."""
    if lines:
        say(console, LACKING, "bold")
        for line in lines:
            say(console, line)
        console.print()


def _print_missing(data: Mapping[str, Any], console: Console) -> None:
    """Print what the files do not declare and the fit has, and what declares it."""
    for one in data["missing"]:
        text = one["text"]
        said = f"{one['name']}: {one['words']}; not declared, found (chi-square {text['chi_square']} for {one['dof']})"
        say(console, said, "bold")
        own_table(one["rows"]).print(console)
        say(console, f"To declare it, {text['where']}:")
        for line in one["toml"].strip().splitlines():
            say(console, f"    {line}" if line else "")
        console.print()


def _print_priors(data: Mapping[str, Any], console: Console) -> None:
    """Print the priors, and how sure the records alone would be, where there are any."""
    priors = prior_table(data)
    if priors.rows:
        say(console, "Priors; records alone: sigma without any prior, empty where the last fit left them out", "bold")
        priors.print(console)


def _print_held_out(data: Mapping[str, Any], console: Console) -> None:
    """Print how the records kept out of the fit are predicted, where there are any; those left out by themselves."""
    for rows, words in ((held_out(data["validation"]), HELD_OUT_WORDS), (left_out(data["validation"]), LEFT_OUT_WORDS)):
        if rows:
            unit = "N m" if torque_alone(rows) else "the unit"
            say(console, f"{words}; residual in {unit}", "bold")
            validation_table(rows).print(console)
    orders = held_out(data["orders"])
    if orders:
        unit = "N m" if torque_alone(orders) else "the unit"
        said = f"At orders of the step rate (1: once a full step); amplitudes in {unit}, RMS over windows"
        say(console, said, "bold")
        order_table(orders).print(console)
