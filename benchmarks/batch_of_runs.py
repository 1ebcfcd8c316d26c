"""What runs side by side save: the 60 s sweep of eight parameter sets in one kernel, beside the same one after another.

CPU time, the shortest of several, side by side in one run. Then a bootstrap of a finished fit, its draws side by side
along the estimate's derivatives, beside the same draws refitted one by one; and how far the two end apart.

    python benchmarks/batch_of_runs.py [FIT] [--draws 16] [--repeats 5] [--out FILE]
"""

import argparse
import json
import time
from datetime import UTC, datetime
from pathlib import Path
from unittest.mock import patch

import numpy as np

from bench_sweep import RESULTS, machine
from mechid.fits.load import load_fit
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.refit.bootstrap import bootstrap
from mechid.simulation.batch import SETS, Batch
from mechid.simulation.simulator import Simulator, TimeBase

DEMO = Path("demo")
MOST_SWITCHES = 2000
SPREADS = (0.0, 0.001, 0.01)
"""Standard deviations of the sets around the fit, as shares: how far apart they stick and slip."""


def main() -> None:
    """Measure, print and save."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("fit", nargs="?", type=Path, default=DEMO, help="result folder of mechid demo")
    parser.add_argument("--draws", type=int, default=16, help="of the bootstrap")
    parser.add_argument("--repeats", type=int, default=5, help="of each sweep")
    parser.add_argument("--out", type=Path, default=None, help=f"a new file in {RESULTS} by default")
    arguments = parser.parse_args()
    found = {"machine": machine(), "sets": SETS, "sweeps": sweeps(arguments.fit, arguments.repeats)}
    found["bootstrap"] = draws(arguments.fit, arguments.draws)
    print(json.dumps(found, indent=1))
    path = arguments.out or RESULTS / f"batch-{datetime.now(UTC):%Y%m%dT%H%M%S}.json"
    path.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def sweeps(fit: Path, repeats: int) -> list[dict[str, float]]:
    """Return seconds of each set's sweep alone and in a batch, and the error of the batch, for each spread."""
    found = load_fit(fit)
    mechanism = found.mechanism
    command = next(r.command for r in found.required_campaign.records if r.name == "sweep")
    simulator = Simulator(mechanism.plant, command, TimeBase(1e4, 600_000))
    p, rng = mechanism.kernel_values(), np.random.default_rng(1)
    whole = p == np.round(p)
    rows = []
    for spread in SPREADS:
        points = np.where(whole, p, p * (1.0 + spread * rng.standard_normal((SETS, p.size))))
        rows.append({"spread": spread, **_sweep(simulator, points, repeats)})
    return rows


def _sweep(simulator: Simulator, points: np.ndarray, repeats: int) -> dict[str, float]:
    none = np.zeros((points.shape[1], 0))
    alone, together, y = [], [], np.zeros((2, SETS, simulator.base.samples))
    for _ in range(repeats):
        began = time.process_time()
        runs = [simulator.run(p, directions=none, events=MOST_SWITCHES) for p in points]
        for k, run in enumerate(runs):
            for block in run.blocks():
                y[0, k, block.start : block.stop] = block.y[:, 0]
        alone.append(time.process_time() - began)
        began = time.process_time()
        side = [simulator.run(p, directions=none, events=MOST_SWITCHES) for p in points]
        for first, stop, outputs in Batch(side).blocks():
            y[1, :, first:stop] = outputs[:, :, 0]
        together.append(time.process_time() - began)
    error = np.sqrt(np.mean((y[1] - y[0]) ** 2, axis=1) / np.mean(y[0] ** 2, axis=1))
    same = all(len(a.switching.time) == len(b.switching.time) for a, b in zip(runs, side, strict=True))
    return {
        "alone_s": min(alone) / SETS,
        "together_s": min(together) / SETS,
        "ratio": min(together) / min(alone),
        "rms_error": float(error.max()),
        "same_switches": same,
        "switches": len(runs[0].switching.time),
    }


def draws(fit: Path, count: int) -> dict[str, float]:
    """Return seconds a draw side by side and one by one, and how far apart the draws end, in standard deviations."""
    optimum = load_fit(fit).optimum_on(1)
    with one_core_algebra():
        bootstrap(optimum, SETS)  # kernels compiled
        began = time.process_time()
        side = bootstrap(optimum, count)
        together = time.process_time() - began
        module = "mechid.identification"
        with patch(f"{module}.refit.bootstrap.chord_at", lambda *_: None):
            began = time.process_time()
            ones = bootstrap(optimum, count)
            alone = time.process_time() - began
    sigma = {spread.name: spread.std_error or spread.deviation for spread in side.spreads}
    apart = [
        [(a.values[n] - b.values[n]) / s for n, s in sigma.items()] for a, b in zip(side.draws, ones.draws, strict=True)
    ]
    return {
        "draws": count,
        "alone_s": alone / count,
        "together_s": together / count,
        "times_faster": alone / together,
        "apart_rms": float(np.sqrt(np.mean(np.square(apart)))),
        "apart_worst": float(np.abs(apart).max()),
    }


if __name__ == "__main__":
    main()
