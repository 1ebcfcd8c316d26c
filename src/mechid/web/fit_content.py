"""Page content for a running or finished fit: words, numbers, and progress curves."""

from __future__ import annotations

import math
import statistics
from collections.abc import Mapping, Sequence
from typing import Any

from mechid.identification.computation.progress import Progress
from mechid.ink.digits import digits
from mechid.web.fit_run import FitRun, RunState
from mechid.web.followed_run import FollowedRun
from mechid.web.knobs import Knob

MOST_REPORTS = 300
"""Most reports in the figure; of more, some are omitted."""
Course = list[tuple[int, float]]
"""Pairs of report number and value."""
Data = dict[str, Any]
ELSEWHERE = {
    RunState.RUNNING: "an identification is at work elsewhere",
    RunState.FINISHED: "the identification elsewhere has ended",
    RunState.CANCELLED: "the identification elsewhere has stopped",
}


def run_data(run: FitRun | FollowedRun, knobs: Mapping[str, Knob]) -> Data:
    """Return the state of a fit."""
    latest = run.reports[-1] if run.reports else None
    words = {
        RunState.RUNNING: "at work; standard errors and verdict come last",
        RunState.FINISHED: "ended; the parameters are at its estimate, Undo takes them back",
        RunState.CANCELLED: "cancelled; the parameters are where you left them",
        RunState.FAILED: run.fault,
    }[run.state]
    if run.is_elsewhere:
        words = run.fault or ELSEWHERE[run.state]
    values = latest.values if latest else {}
    places = {name: knobs[name].place(value) for name, value in values.items() if name in knobs}
    return {
        "state": run.state.value,
        "elsewhere": run.is_elsewhere,
        "words": words,
        "places": places,
        "elapsed": f"{run.elapsed_s:.0f} s",
        **_progress(latest),
        "noise": _worst_record(run.reports),
    }


def _progress(latest: Progress | None) -> Data:
    if latest is None:
        return {"stage": "starting", "line": "", "cost": ""}
    finite = latest.cost is not None and math.isfinite(latest.cost)
    return {
        "stage": f"stage {latest.number} of {latest.total}: {latest.stage}" if latest.total > 1 else latest.stage,
        "line": latest.line,
        "cost": f"cost {latest.cost:.6g}" if finite else "",
    }


def _worst_record(reports: Sequence[Progress]) -> str:
    """Describe the worst record in the latest report with noise ratios."""
    ratios = next((r.over_noise for r in reversed(reports) if r.over_noise), None)
    if not ratios:
        return ""
    name, ratio = max(ratios.items(), key=lambda item: item[1])
    off = f"at {digits(ratio, 3)} noise floors" if math.isfinite(ratio) else "not simulated to its end"
    return f"worst record {name} {off}"


def progress_curves(
    reports: Sequence[Progress], knobs: Mapping[str, Knob]
) -> tuple[dict[str, Course], dict[str, Course]]:
    """Return curves of the worst and the median residual-to-noise ratio, and of each parameter in its range.

    Each curve is a list of report numbers and values. A record whose simulation fails has no ratio, which leaves a gap
    in the curve of the worst.
    """
    ratios_of = [(k, list(r.over_noise.values())) for k, r in enumerate(reports, 1) if r.over_noise]
    ratios = {
        "worst": [(k, worst) for k, own in ratios_of if math.isfinite(worst := max(own))],
        "median": [(k, middle) for k, own in ratios_of if math.isfinite(middle := statistics.median(own))],
    }
    apart = max(len(reports) // MOST_REPORTS, 1)
    # The latest report is always shown.
    drawn = [(k, r) for k, r in enumerate(reports, 1) if k % apart == 0 or k == len(reports)]
    places: dict[str, Course] = {}
    for k, report in drawn:
        for name, value in report.values.items():
            if name in knobs:
                places.setdefault(name, []).append((k, knobs[name].place(value)))
    return ratios, places
