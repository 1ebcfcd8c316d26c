"""Verdict on a budget: requirements met, drivers of the margin, worst rate, and sufficiency of one-way coupling."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from mechid.ink.data import Data
from mechid.ink.digits import plain
from mechid.ink.document import BAD, CAUTION, GOOD, Lines, Verdict
from mechid.specification.verdict import Verdict as EmissionVerdict

HEADLINE = {
    GOOD: "All requirements are met, also at the unfavourable end of their 95 % bands.",
    CAUTION: "No requirement is exceeded; read the cautions before this is relied on.",
    BAD: "Not all requirements are met.",
}
NO_REQUIREMENT = "No requirement is given; the disturbance alone is shown."
SHOWN_SHARES, LEAST_SHARE = 3, 0.01
SHOWN_ROWS = 4
"""Requirements listed, the least margins first; all are in the table."""
NEAR = 0.03
DIFFERS = 0.05
"""Relative difference of two-way and one-way results from which it is reported."""


def budget_verdict(data: Data) -> Verdict:
    """Return the verdict on the data of `budget_numbers`."""
    rows = sorted(data["requirements"], key=lambda r: r["decided"]["margin95"][0])
    tone = _tone(data)
    return Verdict(
        HEADLINE[tone] if rows or data["emission_requirements"] else NO_REQUIREMENT,
        (
            ("Are the requirements met?", _all_met(rows, data["emission_requirements"])),
            ("What drives the margin?", _drivers(rows)),
            ("Where is it worst?", _worst(data)),
            ("Is one-way coupling enough?", coupling_lines(data)),
        ),
        tone,
        Lines(data["warnings"], "warning", "Warnings", "yellow"),
    )


def unmet(data: Data) -> list[str]:
    """Return the names of the requirements that are not shown to be met, each once."""
    pointing = [r["requirement"] for r in data["requirements"] if not r["decided"]["met"]]
    exported = [one["name"] for one in data["emission_requirements"] if one["verdict"] != EmissionVerdict.PASS]
    return list(dict.fromkeys([*pointing, *exported]))


def _tone(data: Data) -> str:
    rows = data["requirements"]
    exported = {one["verdict"] for one in data["emission_requirements"]}
    if any(r["decided"]["margin"] < 0.0 for r in rows) or EmissionVerdict.FAIL in exported:
        return BAD
    is_met = all(r["decided"]["met"] for r in rows) and exported <= {EmissionVerdict.PASS}
    return GOOD if is_met and not data["warnings"] else CAUTION


def _all_met(rows: Sequence[Data], exported: Sequence[Data]) -> list[str]:
    more = len(rows) - SHOWN_ROWS
    rest = (
        [f"{more} more, with margins above {100.0 * rows[SHOWN_ROWS - 1]['decided']['margin95'][0]:.1f} % at 95 %"]
        if more > 0
        else []
    )
    return [*(_met(r) for r in rows[:SHOWN_ROWS]), *rest, *map(_exported_line, exported)] or [NO_REQUIREMENT]


def _exported_line(one: Data) -> str:
    text = one["text"]
    at = f", {text['rate']} steps/s, {text['frequency']} Hz" if one["worst"] else ""
    margin = f"; margin {text['margin']} dB" if text["margin"] else ""
    return f"{one['name']}, {one['direction']}{at}: {text['verdict']}{margin}"


def _met(r: Data) -> str:
    decided = r["decided"]
    low, high = (100.0 * m for m in decided["margin95"])
    at = "" if decided["at_rate"] is None else f" at {plain(decided['at_rate'], 4)} steps/s"
    line = (
        f"{r['requirement']}, {r['mode']}{at}: {standing_word(decided)}; margin {100.0 * decided['margin']:.1f} % of "
        f"the limit ({low:.1f} to {high:.1f} %)"
    )
    return line if decided["coupling"] == "one-way" else f"{line} two-way; {100.0 * r['margin']:.1f} % one-way"


def standing_word(decided: Data) -> str:
    """Return the result of a requirement in a word or two."""
    if decided["met"]:
        return "met"
    return "exceeded" if decided["margin"] < 0.0 else "not sure"


def drivers(shares: Mapping[str, float], shown: int = SHOWN_SHARES) -> str:
    """Return the largest shares in words.

    Examples
    --------
    >>> drivers({"gear.damping": 0.7, "friction.viscous": 0.295, "load.inertia": 0.005})
    'gear.damping 70 %, friction.viscous 30 %'
    """
    largest = sorted(shares.items(), key=lambda item: -abs(item[1]))[:shown]
    return ", ".join(f"{name} {100.0 * s:.0f} %" for name, s in largest if abs(s) >= LEAST_SHARE)


def _drivers(rows: Sequence[Data]) -> list[str]:
    out, named = [], set()
    for r in rows:
        if r["requirement"] in named:
            continue
        named.add(r["requirement"])
        line = f"{r['requirement']}, {r['mode']}: the band by {drivers(r['variance_shares']) or 'nothing'}"
        lacking = r["decided"]["residual_rad"] / r["limit_rad"]
        if lacking >= LEAST_SHARE:
            line += f"; what the model lacks takes {100.0 * lacking:.2g} % of the limit"
        spread = drivers(r["spread_shares"])
        out.append(f"{line}; the ensemble by {spread}" if spread else line)
    return out or [NO_REQUIREMENT]


def _worst(data: Data) -> list[str]:
    out = []
    for mode in data["modes"]:
        rate, rms, coupling = _largest_rms(mode)
        size = ", ".join(f"{axis} {plain(v, 3)} rad" for axis, v in zip(data["line_of_sight"], rms, strict=True))
        when = f" ({plain(mode['worst_time_s'], 4)} s into the profile)" if mode["kind"] == "profile" else ""
        near = _nearest_crossing(data, rate)
        out.append(f"{mode['name']}: largest RMS {coupling} at {plain(rate, 4)} steps/s{when}, {size}{near}")
        for name, ranges in mode["avoid"].items():
            if ranges:
                avoided = ", ".join(f"{a:.4g} to {b:.4g}" for a, b in ranges)
                out.append(f"{mode['name']}, {name}: avoid {avoided} steps/s ({deciding_coupling(mode)})")
    return out


def _largest_rms(mode: Data) -> tuple[float, Sequence[float], str]:
    """Return the rate of the largest RMS, the RMS along each line of sight there, and its coupling.

    At steady rates this is the two-way result if computed, since it decides; for a profile it is one-way.
    """
    two_way = mode["over_rate"]["rms_two_way_rad"] if mode["kind"] == "steady" else None
    if two_way is None:
        return mode["worst_rate"], mode["line_of_sight_rms_rad"], "one-way"
    k = max(range(len(two_way)), key=lambda k: max(two_way[k]))
    return mode["rates"][k], two_way[k], "two-way"


def deciding_coupling(mode: Data) -> str:
    """Return the coupling of the deciding levels over the rate, "one-way" or "two-way"."""
    return str(mode["over_rate"]["decided"]["coupling"])


def _nearest_crossing(data: Data, rate: float) -> str:
    """Return the crossing nearest to a rate, within 3 % of it."""
    off = {abs(c["rate"] / rate - 1.0): c for c in data["crossings"]} if rate else {}
    if not off or min(off) > NEAR:
        return ""
    c = off[min(off)]
    return f"; there order {c['order']:g} meets {c['mode']} ({plain(c['frequency_hz'], 4)} Hz)"


def coupling_lines(data: Data) -> list[str]:
    """Return sentences on whether one-way coupling suffices and on the change by coupling both, one per mode."""
    coupling = data["coupling"]
    gain, enough = coupling["largest_at_lines"], coupling["suffices_below"]
    if not _is_known(gain):
        return ["The driving-point receptance is not known, so that the criterion cannot be given: one-way alone."]
    said = (
        f"|driving-point receptance x dynamic stiffness| is {plain(gain, 2)} at most where lines stand or pass; "
        f"one-way suffices where it is far below 1, here {enough:g}: "
    )
    joined = any(mode["line_of_sight_rms_two_way_rad"] is not None for mode in data["modes"])
    remedy = "the two-way result decides" if joined else "give the structure's modes for a two-way result"
    out = [said + ("it does." if gain <= enough else f"it does not, {remedy}.")]
    for mode in data["modes"]:
        two_way = mode["line_of_sight_rms_two_way_rad"]
        if two_way is None:
            out.append(f"{mode['name']}: no two-way result, the structure has no modes to join")
            continue
        pairs = [(o, t) for o, t in zip(mode["line_of_sight_rms_rad"], two_way, strict=True) if o > 0.0]
        change = max((t / o - 1.0 for o, t in pairs), key=abs, default=0.0)
        word = " (a difference that counts)" if abs(change) > DIFFERS else ""
        out.append(f"{mode['name']}: joined, the RMS changes by {100.0 * change:+.2g} %{word}")
    return out


def _is_known(value: Any) -> bool:
    return value is not None and math.isfinite(value)
