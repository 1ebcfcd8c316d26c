"""What the page says and draws of a fit at work, or ended: words, numbers, and its course."""

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
"""Of a fit: of more, some are left out of the figure."""
Course = list[tuple[int, float]]
"""Number of a report, and a value."""
Data = dict[str, Any]
ELSEWHERE = {
    RunState.RUNNING: "an identification is at work elsewhere",
    RunState.FINISHED: "the identification elsewhere has ended",
    RunState.CANCELLED: "the identification elsewhere has stopped",
}


def run_data(run: FitRun | FollowedRun, knobs: Mapping[str, Knob]) -> Data:
    """Return where a fit stands."""
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
        "noise": _off(run.reports),
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


def _off(reports: Sequence[Progress]) -> str:
    """Return how far off the worst record was when that was looked at last."""
    ratios = next((r.over_noise for r in reversed(reports) if r.over_noise), None)
    if not ratios:
        return ""
    name, ratio = max(ratios.items(), key=lambda item: item[1])
    off = f"at {digits(ratio, 3)} noise floors" if math.isfinite(ratio) else "not simulated to its end"
    return f"worst record {name} {off}"


def course(reports: Sequence[Progress], knobs: Mapping[str, Knob]) -> tuple[dict[str, Course], dict[str, Course]]:
    """Return residual over noise floor, of the worst and of the median record, and each parameter between its ends.

    Each is a list of the number of the report and the value. A record that is not simulated to its end has no ratio:
    the worst has a gap there.
    """
    ratios_of = [(k, list(r.over_noise.values())) for k, r in enumerate(reports, 1) if r.over_noise]
    ratios = {
        "worst": [(k, worst) for k, own in ratios_of if math.isfinite(worst := max(own))],
        "median": [(k, middle) for k, own in ratios_of if math.isfinite(middle := statistics.median(own))],
    }
    apart = max(len(reports) // MOST_REPORTS, 1)
    drawn = [(k, r) for k, r in enumerate(reports, 1) if k % apart == 0 or k == len(reports)]
    places: dict[str, Course] = {}
    for k, report in drawn:
        for name, value in report.values.items():
            if name in knobs:
                places.setdefault(name, []).append((k, knobs[name].place(value)))
    return ratios, places
