"""Draw error against time of the 60 s sweep: mechid alone and in batches, C by hand, and whatever else is installed.

mechid, C by hand and CasADi as in bench_sweep.py run the whole sweep; the others run its window from 29.5 to 30.5 s
(960 step edges, no switch of the friction), whose time is multiplied by 60. Errors of all are those of the window,
against C by hand at 64 steps a sample. Each time is the least CPU time of several on one core, a trajectory's share
where eight go side by side. Then what a run of mechid costs by its length and by the directions of its Jacobian.

    python benchmarks/work_precision.py [--repetitions 5] [--only mechid] [--out build/work-precision]
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from bench_sweep import RESULTS, machine
from mechid.command import Command, RateProfile
from mechid.simulation.simulator import Simulator, TimeBase
from peers import mechid_batch, mechid_side, reference_c
from peers import problem as problems
from peers.problem import SAMPLE_TIME, Output, Problem, Run
from peers.sliding import Window

FIRST, LAST = 295_000, 305_000
TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
LENGTHS = (1, 10, 60, 600, 3600)
DIRECTIONS = (0, 5, 10, 15, 20, 30, 40)
LENGTH_OF_JACOBIANS = 10
RATE = 60.0
"""Full steps/s of the runs of each length: 960 microsteps a second, as in the sweep at its middle."""

Point = tuple[str, str, Callable[[], Run]]
"""Whose it is, the setting, and what prepares the run."""


def main() -> None:
    """Measure, print, draw and save."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repetitions", type=int, default=5)
    parser.add_argument("--only", default="", help="a part of the name of the peers to run")
    parser.add_argument("--out", type=Path, help="path of the files without suffix; default: in benchmarks/results/")
    arguments = parser.parse_args()
    core = max(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {core})
    path = arguments.out or RESULTS / f"work-precision-{datetime.now(UTC):%Y%m%dT%H%M%S}"
    path.parent.mkdir(parents=True, exist_ok=True)
    problem = problems.sweep(problems.PAPER)
    found = {"machine": machine() | {"core": core, "peers": _versions()}, "repetitions": arguments.repetitions}
    found["window_s"] = [FIRST * SAMPLE_TIME, LAST * SAMPLE_TIME]
    found["points"] = work_precision(problem, arguments.only, arguments.repetitions)
    found["lengths"] = against_length(arguments.repetitions)
    found["directions"] = against_directions(arguments.repetitions)
    found["machine"]["load_at_end"] = os.getloadavg()
    path.with_suffix(".json").write_text(json.dumps(found, indent=1) + "\n")
    print(table(found))
    draw(found, path)
    print(f"written: {path}.json, .png, .svg")


def _versions() -> dict[str, str | None]:
    found = {}
    for name in ("casadi", "heyoka", "diffrax", "jax"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = None
    return found


def points(problem: Problem, window: Window) -> Iterator[Point]:
    """Yield all points, those of packages that are missing too: they fail when prepared."""
    for n in (1, 2, 4, 8):
        steps = "1 step" if n == 1 else f"{n} steps"
        yield "mechid", steps, partial(mechid_side.prepare, problem, jacobian=False, substeps=n)
    for n in (1, 2, 4):
        steps = "1 step" if n == 1 else f"{n} steps"
        yield "mechid, batch of eight", steps, partial(mechid_batch.prepare, problem, jacobian=False, substeps=n)
    for n in (1, 2, 4, 8, 16):
        yield "C by hand", "1 step" if n == 1 else f"{n} steps", lambda n=n: partial(_by_hand, problem, n)
    yield "CasADi RK4, smoothed", "1 step", lambda: _peer("casadi_peer").prepare(problem, jacobian=False)
    for n in (1, 2, 4, 8):
        steps = "1 step" if n == 1 else f"{n} steps"
        yield "CasADi RK4, window", steps, lambda n=n: _peer("casadi_window").prepare_steps(window, substeps=n)
    for t in TOLERANCES:
        for name, batch in (("heyoka, window", False), ("heyoka, batch of eight, window", True)):
            yield name, f"{t:.0e}", lambda t=t, b=batch: _peer("heyoka_peer").prepare(window, tolerance=t, batch=b)
    for t in TOLERANCES[:-1]:
        yield "diffrax Tsit5, window", f"{t:.0e}", lambda t=t: _peer("diffrax_peer").prepare(window, tolerance=t)
        yield "CVODES, window", f"{t:.0e}", lambda t=t: _peer("casadi_window").prepare_cvodes(window, tolerance=t)
    for method, t in (("LSODA", 1e-4), ("LSODA", 1e-6), ("LSODA", 1e-8), ("DOP853", 1e-6), ("DOP853", 1e-9)):
        yield f"SciPy {method}, window", f"{t:.0e}", lambda m=method, t=t: partial(_scipy, window, m, t)


def _peer(name: str):
    return importlib.import_module(f"peers.{name}")


def _by_hand(problem: Problem, n_substeps: int) -> Output:
    return Output(reference_c.simulate(problem, n_substeps=n_substeps).torque)


def _scipy(window: Window, method: str, rtol: float) -> Output:
    before, estimated = window.before, window.problem.mechanism.estimated()
    run = partial(_peer("scipy_peer").integrate, window.problem, estimated, method=method, rtol=rtol)
    return Output(run(state=before.final, mode=before.mode, first=FIRST, last=LAST), FIRST)


def work_precision(problem: Problem, only: str, repetitions: int) -> list[dict]:
    """Return a row a point: seconds of a trajectory of the whole sweep, and the errors."""
    truth, window = reference_c.truth(problem), Window(problem, FIRST, LAST)
    rows, left_out = [], set()
    for name, setting, prepare in points(problem, window):
        if only not in name or name in left_out:
            continue
        try:
            run = prepare()
            output, seconds = run(), least(run, repetitions)
        except (ImportError, ArithmeticError) as reason:
            print(f"{name}, {setting} left out: {reason}", file=sys.stderr)
            if isinstance(reason, ImportError):
                left_out.add(name)
            continue
        share = (len(output.torque) - 1) / (problem.n_samples - 1)
        sets = mechid_batch.TRAJECTORIES if "batch" in name else 1
        row = {"name": name, "setting": setting, "seconds": seconds / share / sets, "share_of_sweep": share}
        rows.append(row | _errors(output, truth.torque))
        print(f"{name}, {setting}: {row['seconds']:.3g} s, {rows[-1]['rms_error_Nm']:.1e} N m RMS", file=sys.stderr)
    return rows


def _errors(output: Output, truth: np.ndarray) -> dict[str, float]:
    here = output.torque[FIRST - output.first : LAST + 1 - output.first] - truth[FIRST : LAST + 1]
    errors = {"rms_error_Nm": float(np.sqrt(np.mean(here**2))), "max_error_Nm": float(np.abs(here).max())}
    if len(output.torque) == len(truth):
        errors["max_error_of_sweep_Nm"] = float(np.abs(output.torque - truth).max())
    return errors


def least(run: Callable[[], object], repetitions: int) -> float:
    """Return the least CPU time of several, in s."""
    seconds = []
    for _ in range(repetitions):
        began = time.process_time()
        run()
        seconds.append(time.process_time() - began)
    return min(seconds)


def _simulator(seconds: float, capacity: int) -> tuple[Simulator, object]:
    profile = RateProfile.through([(0.0, RATE), (seconds, RATE)])
    command = Command(stepping="micro", microsteps=16, rate=profile)
    mechanism = mechid_side.mechanism_of(problems.sweep(problems.PAPER))
    base = TimeBase(1.0 / SAMPLE_TIME, round(seconds / SAMPLE_TIME) + 1)
    return Simulator(mechanism.plant, command, base, capacity=capacity), mechanism


def _consumed(simulator: Simulator, p: np.ndarray, directions: np.ndarray | None) -> float:
    return sum(float(block.y[-1, 0]) for block in simulator.run(p, directions=directions).blocks())


def against_length(repetitions: int) -> list[dict[str, float]]:
    """Return CPU seconds of runs of one step a sample at a constant rate, by length; the edges are found apart."""
    rows = []
    for seconds in LENGTHS:
        simulator, mechanism = _simulator(seconds, 0)
        began = time.process_time()
        edges_found = len(simulator.excitation.times)
        edges = time.process_time() - began
        run = partial(_consumed, simulator, mechanism.kernel_values(), None)
        run()
        row = {"length_s": seconds, "edges": edges_found, "edges_s": edges}
        rows.append(row | {"run_s": least(run, 2 if seconds > 600 else repetitions)})
    return rows


def against_directions(repetitions: int) -> list[dict[str, float]]:
    """Return CPU seconds of runs with a Jacobian, by the number of its directions: mixtures of the fifteen."""
    simulator, mechanism = _simulator(LENGTH_OF_JACOBIANS, max(DIRECTIONS))
    one_by_one = mechid_side.directions_of(mechanism)
    mixing = np.random.default_rng(1).standard_normal((one_by_one.shape[1], max(DIRECTIONS)))
    rows = []
    for n in DIRECTIONS:
        run = partial(_consumed, simulator, mechanism.kernel_values(), (one_by_one @ mixing)[:, :n].copy())
        run()
        rows.append({"directions": n, "run_s": least(run, repetitions)})
    return rows


def table(found: dict) -> str:
    """Return everything as Markdown."""
    lines = ["| | setting | s a sweep | RMS error N m | largest N m |", "|---|---|---:|---:|---:|"]
    for r in found["points"]:
        errors = f"{r['rms_error_Nm']:.1e} | {r['max_error_Nm']:.1e}"
        lines.append(f"| {r['name']} | {r['setting']} | {r['seconds']:.3g} | {errors} |")
    lines += [f"{r['length_s']} s: edges {r['edges_s']:.3g} s, run {r['run_s']:.3g} s" for r in found["lengths"]]
    lines += [f"{r['directions']} directions: {r['run_s']:.3g} s" for r in found["directions"]]
    return "\n".join(lines)


def draw(found: dict, path: Path) -> None:
    """Draw the three pictures beside the file, as PNG and SVG."""
    figure, (work, length, directions) = plt.subplots(
        1, 3, figsize=(18, 7), layout="constrained", width_ratios=(2, 1, 1)
    )
    names = list(dict.fromkeys(r["name"] for r in found["points"]))
    for k, name in enumerate(names):
        rows = [r for r in found["points"] if r["name"] == name]
        line = work.loglog([r["seconds"] for r in rows], [r["rms_error_Nm"] for r in rows], marker="os^vD"[k % 5])[0]
        line.set(label=name, color=mpl.colormaps["tab20"](k), linestyle="--" if "window" in name else "-")
    work.set(xlabel="CPU s of a trajectory of the 60 s sweep", ylabel="RMS error, 29.5 to 30.5 s, N m")
    work.set_title("dashed: time of the window, times 60")
    work.legend(fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=3)
    for key, label in (("edges_s", "step edges found"), ("run_s", "run")):
        length.loglog([r["length_s"] for r in found["lengths"]], [r[key] for r in found["lengths"]], "o-", label=label)
    length.set(xlabel="length of the record, s", ylabel="CPU s", title="mechid, one step a sample")
    length.legend()
    at = [r["directions"] for r in found["directions"]]
    directions.plot(at, [r["run_s"] / found["directions"][0]["run_s"] for r in found["directions"]], "o-")
    directions.set(xlabel="directions of the Jacobian", ylabel="times the plain run", ylim=0)
    for axes in (work, length, directions):
        axes.grid(alpha=0.3)
    m = found["machine"]
    figure.suptitle(f"{m['processor']}, commit {m['commit'][:8]}, load {m['load'][0]:.1f}", fontsize="small")
    for suffix in (".png", ".svg"):
        figure.savefig(path.with_suffix(suffix), dpi=120)


if __name__ == "__main__":
    main()
