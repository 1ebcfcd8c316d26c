"""Does a quiet table quieten the real mechanism, where the model lacks an effect?

Each bench of `incomplete` is fitted near its truth as in emission_bound.py, a table is made by `mechid.quiet` for one
drawn rate, and the RMS torque on the base with it and with the nominal table is that of the true mechanism, by the
simulator that made the records. Counted are the mechanisms that get quieter, and those whose gain is above its stated
95 % bound. Fits of grade C are refused, as for a user. SYNTHETIC throughout. Resumable: a finished bench is a line of
the file.

    python benchmarks/quiet_incomplete.py [--seeds 0:2] [--effects detent stribeck ...] [--out FILE]
"""

import argparse
import json
import tempfile
import time
from pathlib import Path

import numpy as np

import mechid
from emission_bound import true_spectrum
from incomplete.benches import make_bench
from incomplete.effects import EFFECTS
from incomplete_benches import seeds_from
from mechid.budgets.operating_mode import usual_highest_hz
from mechid.campaign import load_campaign
from mechid.command.phase_table import nominal_table
from mechid.errors import MechidError
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.identify import identify
from mechid.quiet_drives.table_command import table_command

OUT = Path("build/quiet_incomplete.jsonl")
MICROSTEPS, BITS, LOOKED_AT_S = 16, 10, 2.0


def measure(effect: str, seed: int, folder: Path) -> dict[str, object]:
    """Return the stated and the true gain of one bench, dB."""
    begun = time.process_time()
    bench = make_bench(effect, seed, folder)
    fit = identify(load_campaign(folder), near=dict(bench.truth), workers=1)
    out: dict[str, object] = {"effect": effect, "seed": seed, "outcome": fit.outcome.code, "grade": str(fit.grade)}
    rate = round(float(np.random.default_rng((seed, len(effect), 23)).uniform(15.0, 100.0)), 2)
    try:
        found = mechid.quiet(
            fit, {"rates": [rate], "range": {"from": 10.0, "to": 120.0}, "microsteps": MICROSTEPS, "bits": BITS}
        )
    except MechidError as error:
        return out | {"refused": str(error)}
    (gain,) = found.improvement.gains
    before, after = (true_rms(effect, seed, rate, one) for one in (nominal_table(MICROSTEPS), found.table))
    return out | {
        "rate": rate,
        "before_Nm": before,
        "after_Nm": after,
        "true_db": 20.0 * float(np.log10(before / after)),
        "stated_db": gain.gain_db,
        "bound_db": gain.bound_db,
        "cpu_s": time.process_time() - begun,
    }


def true_rms(effect: str, seed: int, rate: float, table: np.ndarray) -> float:
    """Return the RMS of the true torque on the base with a table, up to the frequency that its gain counts, N m."""
    frequency, spectrum = true_spectrum(effect, seed, "micro", MICROSTEPS, rate, LOOKED_AT_S, table)
    kept = (frequency > 0.0) & (frequency <= usual_highest_hz(table_command(table, 1.0), rate))
    return float(np.sqrt(0.5 * np.sum(np.abs(spectrum[kept]) ** 2)))


def main() -> None:
    """Make the tables that are not in the file yet, and print the shares."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=seeds_from, default=(0, 2), metavar="A:B")
    parser.add_argument("--effects", nargs="*", default=list(EFFECTS))
    parser.add_argument("--out", type=Path, default=OUT)
    asked = parser.parse_args()
    asked.out.parent.mkdir(parents=True, exist_ok=True)
    rows = [json.loads(line) for line in asked.out.read_text().splitlines()] if asked.out.is_file() else []
    done = {(row["effect"], row["seed"]) for row in rows}
    with one_core_algebra():
        for seed in range(*asked.seeds):
            for effect in asked.effects:
                if (effect, seed) in done:
                    continue
                with tempfile.TemporaryDirectory() as folder:
                    rows.append(measure(effect, seed, Path(folder)))
                print(json.dumps(rows[-1]), flush=True)
                with asked.out.open("a") as file:
                    file.write(json.dumps(rows[-1]) + "\n")
    made = [row for row in rows if "true_db" in row]
    if made:
        quieter = sum(row["true_db"] > 0.0 for row in made)
        held = sum(row["true_db"] >= row["bound_db"] for row in made)
        gains = np.median([[row["true_db"], row["stated_db"], row["bound_db"]] for row in made], axis=0)
        print(
            f"{len(rows)} benches, {len(rows) - len(made)} refused; {quieter} of {len(made)} quieter, bound holds in "
            f"{held}; medians: true {gains[0]:.1f}, stated {gains[1]:.1f}, bound {gains[2]:.1f} dB"
        )


if __name__ == "__main__":
    main()
