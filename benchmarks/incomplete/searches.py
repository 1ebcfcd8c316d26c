"""Benches that the command `mechid identify` searches from the catalogue, in a process of its own."""

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from incomplete.benches import TRUTH_NAME, make_bench
from incomplete.sizes import Sizes
from incomplete.summary import errors_of
from mechid.identification.result.fit import ESTIMATE_NAME

MOST_CPU_S = 1200
"""After so many seconds of CPU a search is ended and counts as one without an end."""
PARAMETER = ("value", "unit", "std_error", "std_error_noise", "status")
MISSING = ("name", "aliases", "share", "parameters")
LAST_LINES = 3
"""Of what a failed command said, kept of it."""


def search_bench(effect: str, seed: int, sizes: Sizes, workers: int, keep: Path) -> dict[str, Any]:
    """Make a bench, identify it as a user does, and return what is kept of it; estimate.json goes to the file `keep`.

    `cpu_s` is of the whole command with its children: start, search, conclusion, report.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make_bench(effect, seed, folder, sizes=sizes, catalogue=True)
        truth = json.loads((folder / TRUTH_NAME).read_text())
        ran = _command(folder, workers)
        estimate = folder / "fit" / ESTIMATE_NAME
        text = estimate.read_text() if estimate.exists() else ""
    bench = {key: truth[key] for key in ("effect", "seed", "size", "simulator", "in_library", "predictable_s")}
    if not text:
        nothing = {"followed": {}, "horizon_s": {}, "missing": [], "parameters": {}}
        return {**bench, **ran, "outcome": "none", "grade": "failed", "path": None, **nothing}
    keep.parent.mkdir(parents=True, exist_ok=True)
    keep.write_text(text)
    return {**bench, **ran, **line_of(json.loads(text), truth["parameters"])}


def line_of(estimate: dict[str, Any], truth: dict[str, float]) -> dict[str, Any]:
    """Return what is kept of an estimate.json: outcome, grade, shares followed, names, parameters beside the truth.

    `z` is the error of each parameter in its stated standard errors; those without one are left out.
    """
    found = estimate["parameters"]
    line = {
        "outcome": estimate["outcome"]["code"],
        "grade": estimate["grade"],
        "path": estimate["outcome"].get("path"),
        "followed": {name: _followed(one) for name, one in estimate["records"].items()},
        "horizon_s": {name: one["horizon_s"] for name, one in estimate["records"].items()},
        "missing": [{key: one[key] for key in MISSING} for one in estimate["missing"]],
        "parameters": {
            name: {"truth": true, **{key: found[name][key] for key in PARAMETER}} for name, true in truth.items()
        },
    }
    return {**line, "z": dict(errors_of(line))}


def _followed(record: dict[str, Any]) -> float:
    """Return the share of a record that is followed, in percent: that of its channel of which the least is."""
    return min(channel["followed_percent"] or 0.0 for channel in record["channels"].values())


def _command(folder: Path, workers: int) -> dict[str, Any]:
    """Run `mechid identify` on a bench and return its exit status, time, and last words where it gave no fit."""
    command = [sys.executable, "-m", "mechid", "identify", folder, "--out", folder / "fit", "--workers", str(workers)]
    began, began_cpu = time.perf_counter(), _children_s()
    done = subprocess.run(command, capture_output=True, text=True, check=False, preexec_fn=_limited)
    out = {"exit": done.returncode, "cpu_s": _children_s() - began_cpu, "wall_s": time.perf_counter() - began}
    return {**out, "said": done.stderr.splitlines()[-LAST_LINES:] if done.returncode not in (0, 5) else []}


def _limited() -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (MOST_CPU_S, MOST_CPU_S))


def _children_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
