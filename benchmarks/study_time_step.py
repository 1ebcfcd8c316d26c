"""Which time step: methods and substeps compared for accuracy and cost.

Candidates, each at 1, 2 or 4 steps a sample of 0.1 ms:

* plain Runge-Kutta on all 8 states: RK4, Dormand-Prince 5, Butcher 6 (7 stages), DOP853's 8th order;
* Runge-Kutta on 6 states, with the housing mode in closed form, fed by T_res as a parabola (RK4
  only), as a cubic Hermite polynomial (any method), or as the rate of the method's own dense output
  (Dormand-Prince 5);
* the whole linear part in closed form (coils, gear, viscous friction, housing): exponential RK4 of
  Cox and Matthews, and Strang splitting.

All split their steps at the step edges and at the switches of the friction, located to rounding.
Records: full steps at 5, 23, 46 and 92 steps/s from 45 deg and 16 microsteps at 46 steps/s, 1 s
each, and the 60 s sweep; each at the paper's values and for a lightly damped mechanism. The truth is
`peers.reference_c.truth`, another program, at 64 steps a sample.

    python benchmarks/study_time_step.py [--repetitions 5] [--out FILE]
"""

from __future__ import annotations

import argparse
import ctypes
import json
import math
import os
import statistics
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from scipy.integrate import RK45
from scipy.integrate._ivp import dop853_coefficients

from bench_sweep import RESULTS, machine
from peers import reference_c
from peers.problem import LIGHTLY_DAMPED, PAPER, Mechanism, Problem, constant_rate, sweep

SOURCE = Path(__file__).parent / "study_time_step"

COMPILE = (*reference_c.COMPILE, "-ffinite-math-only")  # so that a tableau's zeros cost nothing

WANTED = 1e-5
"""RMS error wanted on every record, relative to the record's RMS torque."""

RK4 = ([[], [1 / 2], [0, 1 / 2], [0, 0, 1]], [1 / 6, 1 / 3, 1 / 3, 1 / 6])

BUTCHER6 = (  # Butcher (1964), sixth order in seven stages
    [
        [],
        [1 / 3],
        [0, 2 / 3],
        [1 / 12, 1 / 3, -1 / 12],
        [25 / 48, -55 / 24, 35 / 48, 15 / 8],
        [3 / 20, -11 / 24, -1 / 8, 1 / 2, 1 / 10],
        [-261 / 260, 33 / 13, 43 / 156, -118 / 39, 32 / 195, 80 / 39],
    ],
    [13 / 200, 0, 11 / 40, 11 / 40, 4 / 25, 4 / 25, 13 / 200],
)

TSITOURAS5 = (  # Tsitouras (2011)
    [
        [],
        [0.161],
        [-0.008480655492356989, 0.335480655492357],
        [2.8971530571054935, -6.359448489975075, 4.3622954328695815],
        [5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525],
        [
            *(5.86145544294642, -12.92096931784711, 8.159367898576159, -0.071584973281401),
            -0.028269050394068383,
        ],
    ],
    [
        *(0.09646076681806523, 0.01, 0.4798896504144996, 1.379008574103742),
        *(-3.290069515436081, 2.324710524099774),
    ],
)

TABLEAUS = {
    "RK4": RK4,
    "DP5": (RK45.A, RK45.B, RK45.P),
    "TSIT5": TSITOURAS5,
    "RK6": BUTCHER6,
    "DOP8": (dop853_coefficients.A[:12], dop853_coefficients.B),
}


@dataclass(frozen=True)
class Candidate:
    """A method at a number of steps a sample; `function` is its name in candidates.c."""

    function: str
    description: str
    substeps: int

    @property
    def name(self) -> str:
        """Name in the tables."""
        return f"{self.description}, m = {self.substeps}"


METHODS = (
    ("rk4_plain", "(a) RK4, 8 states", (1, 2, 4)),
    ("rk4_parabola", "(b) RK4, 6 + housing, parabola", (1, 2, 4)),
    ("rk4_hermite", "(b) RK4, 6 + housing, Hermite", (1, 2, 4)),
    ("dp5_plain", "(c) Dormand-Prince 5, 8 states", (1, 2, 4)),
    ("dp5_hermite", "(c) Dormand-Prince 5, 6 + housing, Hermite", (1, 2)),
    ("dp5_dense", "(c) Dormand-Prince 5, 6 + housing, dense output", (1, 2)),
    ("tsit5_hermite", "(c) Tsitouras 5, 6 + housing, Hermite", (1, 2)),
    ("rk6_plain", "(c) Butcher 6, 8 states", (1, 2)),
    ("rk6_hermite", "(c) Butcher 6, 6 + housing, Hermite", (1, 2)),
    ("dop8_plain", "(c) DOP853's 8th, 8 states", (1,)),
    ("dop8_hermite", "(c) DOP853's 8th, 6 + housing, Hermite", (1,)),
    ("etdrk4_linear", "(d) exponential RK4, linear part closed", (1, 2, 4)),
    ("strang_linear", "(d) Strang, linear part closed", (1, 2, 4)),
)
CANDIDATES = tuple(Candidate(f, text, m) for f, text, ms in METHODS for m in ms)


def main() -> None:
    """Run the study and write its tables and its file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repetitions", type=int, default=5)
    parser.add_argument("--out", type=Path, help="file to write; default: benchmarks/results/")
    arguments = parser.parse_args()
    core = max(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {core})
    rows = []
    library = compiled()
    for problem in (p for mechanism in (PAPER, LIGHTLY_DAMPED) for p in records(mechanism)):
        rows += studied(library, problem, arguments.repetitions)
    print(tables(rows))
    path = arguments.out or RESULTS / f"time-step-{datetime.now(UTC):%Y%m%dT%H%M%S}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({"machine": machine() | {"core": core}, "rows": rows}, indent=1) + "\n")
    print(f"written: {path}")


def records(mechanism: Mechanism) -> Iterator[Problem]:
    """Yield the records of one mechanism."""
    for rate in (5.0, 23.0, 46.0, 92.0):
        yield constant_rate(mechanism, rate, start_angle_deg=45.0)
    yield constant_rate(mechanism, 46.0, microsteps=16)
    yield sweep(mechanism)


def compiled() -> ctypes.CDLL:
    """Compile the candidates with the tableaus' numbers as constants."""
    with tempfile.TemporaryDirectory() as folder:
        header = Path(folder) / "tableaus.h"
        header.write_text("".join(tableau(name, *TABLEAUS[name]) for name in TABLEAUS))
        target = str(Path(folder) / "candidates.so")
        source = str(SOURCE / "candidates.c")
        command = [*COMPILE, "-I", folder, "-o", target, source, "-lm"]
        subprocess.run(command, check=True)
        return ctypes.CDLL(target)


def tableau(name: str, a: list, b: list, dense: list = ()) -> str:
    """Return one Butcher tableau, and its dense output where it is used, as C."""
    stages = len(b)
    table = ", ".join(braced(row[:stages]) for row in a)
    parts = f"{stages}, {{{table}}}, {braced(b)}, {{{', '.join(map(braced, dense)) or 0}}}"
    return f"static const Tableau {name} = {{{parts}}};\n"


def braced(numbers: list) -> str:
    """Return numbers as a C initialiser."""
    return "{" + (", ".join(repr(float(x)) for x in numbers) or "0") + "}"


def studied(library: ctypes.CDLL, problem: Problem, repetitions: int) -> list[dict]:
    """Return a row a candidate for one record; the candidates run in turn."""
    truth = reference_c.truth(problem)
    scale = math.sqrt(np.mean(truth.torque**2))
    found = {c: simulated(library, problem, c) for c in CANDIDATES}
    times = {c: [] for c in CANDIDATES}
    for _ in range(repetitions):
        for candidate in CANDIDATES:
            times[candidate].append(simulated(library, problem, candidate)[2])
    rows = []
    for candidate, (torque, counts, _) in found.items():
        error = torque - truth.torque
        row = {"mechanism": problem.mechanism.name, "record": problem.name}
        row |= {"candidate": candidate.name, "evaluations": counts[1] / problem.duration}
        row["cpu_per_simulated_s"] = statistics.median(times[candidate]) / problem.duration
        row["rms_error_relative"] = math.sqrt(np.mean(error**2)) / scale
        row["max_error_Nm"] = float(np.abs(error).max())
        row["switches"], row["true_switches"] = counts[0], truth.switches
        rows.append(row)
    return rows


def simulated(
    library: ctypes.CDLL, problem: Problem, candidate: Candidate
) -> tuple[np.ndarray, tuple[int, int], float]:
    """Return y, (switches, evaluations of the right-hand side) and the CPU seconds."""
    mechanism = problem.mechanism
    plant = np.concatenate([mechanism.estimated(), mechanism.constants()])
    torque, counts = np.empty(problem.n_samples), (ctypes.c_long * 2)()
    command = reference_c.command_of(problem, candidate.substeps)
    pointers = reference_c.pointer(plant), ctypes.byref(command), reference_c.pointer(torque)
    start = time.process_time()
    getattr(library, candidate.function)(*pointers, counts)
    return torque, (counts[0], counts[1]), time.process_time() - start


def tables(rows: list[dict]) -> str:
    """Return the errors by record, the cost, and the cheapest candidate that is accurate enough."""
    parts = []
    for mechanism in dict.fromkeys(row["mechanism"] for row in rows):
        chosen = [row for row in rows if row["mechanism"] == mechanism]
        for key, title in (
            ("rms_error_relative", "RMS error / RMS of the record"),
            ("max_error_Nm", "largest error in N m"),
        ):
            parts += ["", f"{mechanism}: {title} (* another number of switches)", ""]
            parts += by_record(chosen, key)
    return "\n".join([*parts, "", "cost over all records", "", *costs(rows)])


def by_record(rows: list[dict], key: str) -> list[str]:
    """Return lines with a candidate each and a column a record."""
    names = list(dict.fromkeys(row["record"] for row in rows))
    lines = ["| candidate | " + " | ".join(names) + " |", "|---" + "|---:" * len(names) + "|"]
    for candidate in CANDIDATES:
        cells = [candidate.name]
        for row in (row for row in rows if row["candidate"] == candidate.name):
            mark = "" if row["switches"] == row["true_switches"] else "*"
            cells.append(f"{row[key]:.1e}{mark}")
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def costs(rows: list[dict]) -> list[str]:
    """Return evaluations and CPU time of each candidate, cheapest first, and its worst error."""
    lines = [
        "| candidate | evaluations / sample, sweep | CPU ms / s, sweep | CPU ms / s, steps "
        "| worst RMS error | enough |",
        "|---|---:|---:|---:|---:|---|",
    ]
    summary = []
    for candidate in CANDIDATES:
        own = [row for row in rows if row["candidate"] == candidate.name]
        sweeps = [row for row in own if row["record"] == "sweep"]
        steps = [row for row in own if row["record"] != "sweep"]
        cost = [1e3 * mean(part, "cpu_per_simulated_s") for part in (sweeps, steps)]
        worst = max(row["rms_error_relative"] for row in own)
        evaluations = mean(sweeps, "evaluations") / 1e4
        summary.append((cost[0], evaluations, cost[1], worst, candidate.name))
    for sweep_cost, evaluations, step_cost, worst, name in sorted(summary):
        enough = "yes" if worst < WANTED else "no"
        numbers = f"{evaluations:.2f} | {sweep_cost:.2f} | {step_cost:.2f} | {worst:.1e}"
        lines.append(f"| {name} | {numbers} | {enough} |")
    return lines


def mean(rows: list[dict], key: str) -> float:
    """Return the mean of one entry of the rows."""
    return statistics.fmean(row[key] for row in rows)


if __name__ == "__main__":
    main()
