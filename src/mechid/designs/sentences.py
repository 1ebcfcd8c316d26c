"""Sentences of a design: gain, step loss, holes, peaks, excluded candidates."""

from __future__ import annotations

from mechid.designs.proposal import criterion_words
from mechid.ink.data import Data

JSON_NAME = "design.json"
SHOWN_PEAKS, SHOWN_OBJECTIONS = 4, 12


def headline(data: Data) -> str:
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


def loss_words(data: Data) -> str:
    """Return the explanation of the table of step loss, with the resolution of the search."""
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


def hole_lines(data: Data) -> list[str]:
    """Return the rates, at the assumed values, at which each stepping loses steps though it holds at higher ones."""
    return [
        f"{row['stepping']} stepping, {words}: "
        + ", ".join(f"{first:.0f} to {last:.0f}" for first, last in row[key]["holes"])
        + f" steps/s; {_beyond(row[key])}"
        for row in data["step_loss"]
        for key, words in (("pull_in", "started at once"), ("pull_out", "brought there slowly"))
        if row[key]["holes"] and not row["changed"]
    ]


def _beyond(limit: Data) -> str:
    if limit["limit"] is None:
        return f"above, it holds to the highest rate looked at, {limit['searched'][1]:.0f} steps/s"
    return f"above {limit['limit']:.0f} steps/s it holds nowhere up to {limit['searched'][1]:.0f}"


def peak_lines(data: Data) -> list[str]:
    """Return the rates at which each stepping's torque is largest."""
    return [
        f"{m['stepping']} stepping: largest at "
        + ", ".join(f"{p['rate']:.3g} steps/s ({p['amplitude_Nm']:.2g} N m)" for p in m["peaks"][:SHOWN_PEAKS])
        for m in data["torque_over_rate"]
        if m["peaks"]
    ]


def left_out_lines(data: Data) -> list[str]:
    """Return the candidates that cannot be driven or are too risky, each with its reason."""
    lines = [f"{c['name']}: {c['objection']}" for c in data["candidates"] if c["objection"]]
    more = len(lines) - SHOWN_OBJECTIONS
    return [*lines[:SHOWN_OBJECTIONS], f"and {more} more, which stand in {JSON_NAME}"] if more > 0 else lines
