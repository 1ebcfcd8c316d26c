"""A fleet of demo-sized campaigns from end to end: how long it takes, and whether what it says is true. Synthetic.

Units differ by 2 % in each parameter, each at a temperature of its own, over which the winding's resistance rises as
copper does and viscous friction falls. The benches lie in FOLDER and are made where they are missing; stopped and
begun again it goes on where it stopped.

    python benchmarks/fleet_of_twenty.py FOLDER [UNITS]
"""

import json
import sys
import time
from pathlib import Path

import numpy as np

from mechid.campaign.bench import TRUTH, write_bench
from mechid.fleets.fleet import Fleet, make_fleet
from mechid.fleets.fleet_file import read_fleet_file

SPREAD, SPREAD_DEG = 0.02, 3.0
COPPER, VISCOUS = 0.0039, -0.004
"""Relative change a kelvin."""
DRY = ("friction.static", "friction.coulomb")
"""They have one factor: static friction is never below Coulomb's."""


def main() -> None:
    """Make benches, identify the fleet, and print times and what was found beside the truth."""
    folder, units = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 20
    file = make_benches(folder, units)
    began, spent = time.perf_counter(), time.process_time()
    out = folder / "fleet"
    made = make_fleet(read_fleet_file(file), out, say=_clock())
    print(f"identified: {time.perf_counter() - began:.1f} s, {time.process_time() - spent:.1f} s of one core's time")
    spent = time.process_time()
    for path in made.write(out):
        print(f"written: {path}")
    print(f"statistics, table and page: {time.process_time() - spent:.1f} s of one core's time")
    _print_truth(made, folder)


def make_benches(folder: Path, units: int) -> Path:
    """Write the benches that are missing, and the fleet file; return it."""
    entries = []
    for k in range(units):
        rng = np.random.default_rng(1000 + k)
        kelvin, place = float(rng.uniform(-40.0, 30.0)), folder / f"FM{k + 1:02d}"
        if not (place / "sweep.csv").exists():
            write_bench(place, seed=100 + k, truth=truth_of(rng, kelvin))
        entries.append(
            f'[[campaign]]\nfolder = "{place.name}"\ncovariates = {{ temperature_degC = {20.0 + kelvin:.3f} }}\n'
        )
    (folder / "fleet.toml").write_text("\n".join(entries), encoding="utf-8")
    return folder / "fleet.toml"


def truth_of(rng: np.random.Generator, kelvin: float) -> dict[str, float]:
    """Draw the values of a unit so many kelvin above 20 degC."""
    out = {}
    for name, value in TRUTH.items():
        drawn = rng.standard_normal()
        out[name] = value + SPREAD_DEG * drawn if name.endswith("_deg") else value * (1.0 + SPREAD * drawn)
    out[DRY[1]] = TRUTH[DRY[1]] * out[DRY[0]] / TRUTH[DRY[0]]
    out["stepper.coil_resistance"] *= 1.0 + COPPER * kelvin
    out["friction.viscous"] *= 1.0 + VISCOUS * kelvin
    return out


def _clock():
    """Return a listener that prints each line with the processor time since the last."""
    last = [time.process_time()]

    def say(line: str) -> None:
        now = time.process_time()
        print(f"{now - last[0]:7.1f} s  {line}", flush=True)
        last[0] = now

    return say


def _print_truth(made: Fleet, folder: Path) -> None:
    """Print what was found beside what the benches were made with."""
    truths = [json.loads((m.source / "truth.json").read_text(encoding="utf-8")) for m in made.asked.members]
    print(f"failed: {', '.join(made.failed) or 'none'}; in {folder}")
    for found in (one.result for one in made.trends if one.found):
        level = abs(found.level)
        print(f"trend: {found.name} {100 * found.slope / level:.3f} +- {100 * found.error / level:.3f} % a kelvin")
    for p in made.parameters:
        if p.spread is None or p.along is not None or p.name not in truths[0]:
            continue
        true = np.array([t[p.name] for t in truths])
        low, high = p.spread.spread95
        inside = "holds" if low <= true.std(ddof=1) <= high else "misses"
        print(
            f"{p.name}: spread {p.spread.spread:.3g} ({low:.3g} to {high:.3g}) {inside} that of the benches, "
            f"{true.std(ddof=1):.3g}; outliers {len(p.outliers)}"
        )


if __name__ == "__main__":
    main()
