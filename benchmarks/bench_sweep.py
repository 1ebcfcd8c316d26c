"""Time the 60 s microstep sweep side by side: mechid alone and eight at once, a C loop by hand, CasADi, SciPy.

W1 simulates 600 001 samples at 10 kHz with 57 599 step edges; W2 also computes the Jacobian of the
measured torque to the 15 estimated parameters. Every peer whose import is there runs on the same
core, in turn, several times; the table shows medians of CPU time. Errors are against the C loop at
64 steps a sample, which is itself held against SciPy's DOP853 at the run's end.

    python benchmarks/bench_sweep.py [--repetitions 5] [--only "C by hand" ...] [--avx2] [--out FILE]

With --avx2, mechid and the C loop are compiled for a processor without AVX-512 (x86-64-v3), which any machine with
AVX2 can run.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import platform
import statistics
import subprocess
import sys
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import ModuleType

import numpy as np

from peers import problem as problems
from peers import reference_c
from peers.problem import Output, Problem, Run

PEERS = ("mechid_side", "mechid_fine", "mechid_batch", "reference_c", "casadi_peer", "scipy_peer")
WORKLOADS = {"W1": False, "W2": True}
"""Name of the workload -> whether it computes the Jacobian."""

RESULTS = Path(__file__).parent / "results"
CHECKED_SECONDS = 1.0
AVX2 = {
    "NUMBA_CPU_NAME": "x86-64-v3",
    "NUMBA_CPU_FEATURES": "+avx,+avx2,+bmi,+bmi2,+cmov,+cx8,+cx16,+f16c,+fma,+fxsr,+lzcnt,+mmx,+movbe,+popcnt,+sahf,"
    "+sse,+sse2,+sse3,+ssse3,+sse4.1,+sse4.2,+xsave",
}
"""Environment in which Numba compiles for a processor without AVX-512; it is read when Numba is first imported."""


def main() -> None:
    """Run the benchmark and write its table and its file."""
    arguments = _arguments()
    if arguments.avx2 and os.environ.get("NUMBA_CPU_NAME") != AVX2["NUMBA_CPU_NAME"]:
        # Numba and the C peer read the target at import.
        os.execve(sys.executable, [sys.executable, *sys.argv], os.environ | AVX2)
    core = max(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {core})
    problem = problems.sweep(problems.PAPER)
    runs = prepared(problem, arguments.only)
    times, outputs = timed(runs, arguments.repetitions)
    result = {
        "machine": machine() | {"core": core, "target": reference_c.PROCESSOR},
        "repetitions": arguments.repetitions,
        "truth_against_dop853_Nm": check_truth(problem),
        "peers": compared(problem, runs, times, outputs),
    }
    print(table(result["peers"]))
    result["mechid_reduction_s"] = reduction_seconds(problem, arguments.repetitions)
    print(f"mechid, Jacobian with reduction: {result['mechid_reduction_s']:.3g} s CPU")
    print(f"truth against DOP853, first {CHECKED_SECONDS:g} s: {result['truth_against_dop853_Nm']}")
    path = arguments.out or RESULTS / f"sweep-{datetime.now(UTC):%Y%m%dT%H%M%S}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(result, indent=1) + "\n")
    print(f"written: {path}")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repetitions", type=int, default=5)
    parser.add_argument("--only", nargs="+", default=[""], help="parts of the names of the peers to run")
    parser.add_argument("--avx2", action="store_true", help="compile for a processor without AVX-512")
    parser.add_argument("--out", type=Path, help="file to write; default: benchmarks/results/")
    return parser.parse_args()


def prepared(problem: Problem, only: Sequence[str]) -> dict[tuple[ModuleType, str], Run]:
    """Import and compile every peer that is there; say which are not."""
    runs = {}
    for name in PEERS:
        try:
            peer = importlib.import_module(f"peers.{name}")
        except ImportError as reason:
            print(f"{name} left out: {reason}", file=sys.stderr)
            continue
        if any(part in peer.NAME for part in only):
            for workload, jacobian in WORKLOADS.items():
                try:
                    runs[peer, workload] = peer.prepare(problem, jacobian=jacobian)
                except NotImplementedError as reason:
                    print(f"{name}, {workload} left out: {reason}", file=sys.stderr)
    return runs


def timed(
    runs: dict[tuple[ModuleType, str], Run], repetitions: int
) -> tuple[dict[tuple[ModuleType, str], list[float]], dict[tuple[ModuleType, str], Output]]:
    """Run all in turn, `repetitions` times after one that is not counted; CPU seconds."""
    times = {key: [] for key in runs}
    outputs = {key: run() for key, run in runs.items()}
    for _ in range(repetitions):
        for key, run in runs.items():
            start = time.process_time()
            run()
            times[key].append(time.process_time() - start)
    return times, outputs


def compared(
    problem: Problem,
    runs: dict[tuple[ModuleType, str], Run],
    times: dict[tuple[ModuleType, str], list[float]],
    outputs: dict[tuple[ModuleType, str], Output],
) -> list[dict]:
    """Return a row a peer: times of the whole sweep, errors, and what the peer is."""
    truth = reference_c.truth(problem, jacobian=True)
    rows = []
    for peer in dict.fromkeys(peer for peer, _ in runs):
        output = outputs[peer, "W1"]
        share = (len(output.torque) - 1) / (problem.n_samples - 1)
        here = slice(output.first, output.first + len(output.torque))
        error = output.torque - truth.torque[here]
        row = {"name": peer.NAME, "remark": peer.REMARK, "share_of_sweep": share}
        row["max_error_Nm"] = float(np.abs(error).max())
        row["rms_error_Nm"] = float(np.sqrt(np.mean(error**2)))
        row["trajectories"] = sets = getattr(peer, "TRAJECTORIES", 1)
        row["jacobian_error"] = jacobian_error(peer, problem, truth.jacobian) if (peer, "W2") in runs else None
        for workload in WORKLOADS:
            found = times.get((peer, workload))
            row[f"{workload}_s"] = statistics.median(found) / share / sets if found else None
            row[f"{workload}_runs_s"] = found
        rows.append(row)
    return rows


def jacobian_error(peer: ModuleType, problem: Problem, truth: np.ndarray) -> float | None:
    """Return the worst column's RMS error relative to the column's RMS, where the peer keeps it."""
    kept = peer.prepare(problem, jacobian=True, keep_jacobian=True)().jacobian
    if kept is None:
        return None
    true = truth[:, : kept.shape[1]]
    return float((np.linalg.norm(kept - true, axis=0) / np.linalg.norm(true, axis=0)).max())


def reduction_seconds(problem: Problem, repetitions: int) -> float:
    """Return the median CPU time of simulation, Jacobian and reduction by mechid."""
    from peers.mechid_side import prepare_reduction

    run = prepare_reduction(problem)
    run()
    seconds = []
    for _ in range(repetitions):
        start = time.process_time()
        run()
        seconds.append(time.process_time() - start)
    return statistics.median(seconds)


def check_truth(problem: Problem) -> float | None:
    """Return the largest difference of the truth to DOP853 at 1e-12, in N m; None without Numba."""
    try:
        from peers import scipy_peer
    except ImportError:
        return None
    short = problems.first_seconds(problem, CHECKED_SECONDS)
    twin = scipy_peer.from_the_start(short, method="DOP853", rtol=1e-12)
    return float(np.abs(reference_c.truth(short).torque - twin).max())


def table(rows: list[dict]) -> str:
    """Return the rows as a Markdown table; ratios are to the first peer."""
    head = f"| peer | W1 s | / {rows[0]['name']} | W2 s | / {rows[0]['name']} "
    lines = [head + "| max error Nm | RMS error Nm | Jacobian |", "|---" + "|---:" * 7 + "|"]
    for row in rows:
        mark = "" if row["share_of_sweep"] == 1.0 else " (extrapolated)"
        cells = [row["name"] + mark]
        for workload in WORKLOADS:
            seconds, first = row[f"{workload}_s"], rows[0][f"{workload}_s"]
            cells.append("-" if seconds is None else f"{seconds:.3g}")
            cells.append("-" if seconds is None or first is None else f"{seconds / first:.2f}")
        cells += [f"{row['max_error_Nm']:.1e}", f"{row['rms_error_Nm']:.1e}"]
        cells.append("-" if row["jacobian_error"] is None else f"{row['jacobian_error']:.0e}")
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join([*lines, *(f"{row['name']}: {row['remark']}" for row in rows)])


def machine() -> dict:
    """Return what the numbers depend on: processor, versions, commit, load."""
    packages = {}
    for name in ("numpy", "scipy", "numba", "casadi", "mechid"):
        try:
            packages[name] = version(name)
        except PackageNotFoundError:
            packages[name] = None
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "load": os.getloadavg(),
        "system": platform.platform(),
        "python": platform.python_version(),
        "gcc": _said("gcc", "-dumpfullversion"),
        "packages": packages,
        "commit": _said("git", "rev-parse", "HEAD"),
        "changed": bool(_said("git", "status", "--porcelain")),
        "time": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


def _said(*command: str) -> str | None:
    done = subprocess.run(command, check=False, capture_output=True, text=True, cwd=Path(__file__).parent)
    return done.stdout.strip() if done.returncode == 0 else None


if __name__ == "__main__":
    main()
