"""Gain of quiet tables: drawn complete mechanisms, 16 microsteps, voltage drive, range 10 to 120 full steps/s.

For each mechanism (family 1 of the recovery benchmark) a table is made at a drawn design rate. Reported are the
reduction of the orders 1, 2 and 4 of the step rate at that rate and over +-20 % of it, the same with every estimated
parameter two standard errors off (of 1 %, with drawn signs), the largest rise of the RMS torque over the range at 40
rates, what 8 bits lose, and the share of the torque reserve that is kept. One line of JSON is appended for each; a
mechanism that is in the file already is not repeated.

    python benchmarks/quiet_tables.py 0:10 [--rates 1] [--out FILE]
"""

import argparse
import json
import statistics
import time
from pathlib import Path

import numpy as np

from mechid.command.phase_table import nominal_table
from mechid.plant.flight import to_flight
from mechid.plant.mechanism import Mechanism
from mechid.quiet_drives.periodic_torque import PeriodicTorque
from mechid.quiet_drives.reserved_search import search_within_reserve
from mechid.quiet_drives.rounding import round_table
from mechid.quiet_drives.settings import QUIET
from mechid.quiet_drives.step_reserve import reserve_rule, torque_reserve
from mechid.quiet_drives.table_basis import table_entries, table_harmonics
from mechid.quiet_drives.table_cost import TableCost
from mechid.quiet_drives.table_search import design_places, range_places, rise_db
from recovery.mechanisms import FAMILIES

OUT = Path("build/quiet.jsonl")
ORDERS = (1.0, 2.0, 4.0)
ENDS = (10.0, 120.0)
MICROSTEPS, BITS = 16, 8
SPREAD = 0.01
"""Relative standard error of a parameter; phases in degrees as if of 57.3."""
SHARE = 0.9


def main() -> None:
    """Make the tables that are not in the file yet, and print the summary."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("seeds", help="FROM:TO")
    parser.add_argument("--rates", type=int, default=1, help="design rates of each table")
    parser.add_argument("--out", type=Path, default=OUT)
    arguments = parser.parse_args()
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    lines = arguments.out.read_text(encoding="utf-8").splitlines() if arguments.out.is_file() else []
    done = {(one["seed"], len(one["rates"])): one for one in map(json.loads, lines)}
    first, last = map(int, arguments.seeds.split(":"))
    for seed in range(first, last):
        if (seed, arguments.rates) not in done:
            done[seed, arguments.rates] = made = measure(seed, arguments.rates)
            with arguments.out.open("a", encoding="utf-8") as file:
                file.write(json.dumps(made) + "\n")
            print(json.dumps(made), flush=True)
    print(summary([done[seed, arguments.rates] for seed in range(first, last)]))


def measure(seed: int, count: int) -> dict[str, object]:
    """Return the figures of one mechanism."""
    rng = np.random.default_rng((7, seed))
    mechanism = to_flight(FAMILIES[1].truth(seed))
    base = nominal_table(MICROSTEPS)
    rates = [float(rng.uniform(15.0, 100.0))] if count == 1 else np.geomspace(12.0, 110.0, count).tolist()
    begun = time.process_time()
    places = design_places([mechanism, *(off(mechanism, rng, 1.0) for _ in range(QUIET.draws))], base, rates, ENDS)
    checked = range_places(mechanism, base, np.geomspace(*ENDS, QUIET.checked_rates).tolist())
    changes = table_harmonics(MICROSTEPS, QUIET.highest_harmonic, mirrored=True)
    cost = TableCost(places, ORDERS, base, 1.0)
    found, exact, kept = search_within_reserve(mechanism, cost, changes, checked, rates, SHARE, lambda _: None)
    rounded = round_table(
        exact,
        found.cost,
        table_entries(MICROSTEPS, mirrored=True),
        BITS,
        1.0,
        reserve_rule(mechanism, base, rates, SHARE),
    )
    took = time.process_time() - begun
    rises = [(rise_db(place, exact), rise_db(place, rounded.values)) for place in checked]
    other = off(mechanism, rng, 2.0)
    return {
        "seed": seed,
        "rates": rates,
        "at": factors(mechanism, base, exact, rates),
        "around": factors(mechanism, base, exact, [r * s for r in rates for s in (0.8, 0.9, 1.1, 1.2)]),
        "off": factors(other, base, exact, rates),
        "gain_db": gains(mechanism, base, exact, rates),
        "gain_8_bit_db": gains(mechanism, base, rounded.values, rates),
        "at_8_bit": factors(mechanism, base, rounded.values, rates),
        "rise_db": max(exact for exact, _ in rises),
        "rise_8_bit_db": max(rounded for _, rounded in rises),
        "kept": kept,
        "reserve": min(
            torque_reserve(mechanism, exact, r) / max(torque_reserve(mechanism, base, r), 1e-9) for r in rates
        ),
        "cpu_s": took,
    }


def off(mechanism: Mechanism, rng: np.random.Generator, sigmas: float) -> Mechanism:
    """Return a mechanism with its unknown parameters off by standard errors, with drawn signs."""
    names = [q.name for q in mechanism.free]
    signs = rng.choice([-1.0, 1.0], size=len(names)) if sigmas > 1.0 else rng.normal(size=len(names))
    by = sigmas * SPREAD * signs
    return mechanism.with_values(
        {
            name: mechanism.value(name) + (np.rad2deg(d) if name.endswith("phase_deg") else d * mechanism.value(name))
            for name, d in zip(names, by, strict=True)
        }
    )


def factors(mechanism: Mechanism, base: np.ndarray, table: np.ndarray, rates: list[float]) -> list[float]:
    """Return the least reduction factor over the rates, of each order."""
    out = []
    for rate in rates:
        before, after = (PeriodicTorque(mechanism, rate).lines(one) for one in (base, table))
        out.append([abs(before.values[before.at(q)]) / abs(after.values[after.at(q)]) for q in ORDERS])
    return np.min(out, axis=0).tolist()


def gains(mechanism: Mechanism, base: np.ndarray, table: np.ndarray, rates: list[float]) -> list[float]:
    """Return the reduction of the RMS torque at each rate, dB."""
    pairs = [[PeriodicTorque(mechanism, rate).lines(one).level for one in (base, table)] for rate in rates]
    return [20.0 * float(np.log10(before / after)) for before, after in pairs]


def summary(rows: list[dict]) -> str:
    """Return the shares that reach the targets, and medians."""

    def share(key: str, least: float) -> str:
        reached = [[value >= least for value in row[key]] for row in rows]
        each = ", ".join(f"order {q:g}: {sum(r[k] for r in reached)}" for k, q in enumerate(ORDERS))
        medians = ", ".join(f"{statistics.median(row[key][k] for row in rows):.1f}" for k in range(len(ORDERS)))
        return f"{key} down by {least:g}: {each}, of {len(rows)}; medians {medians}"

    loss = [max(a - b for a, b in zip(row["gain_db"], row["gain_8_bit_db"], strict=True)) for row in rows]
    return "\n".join(
        [
            share("at", 10.0),
            share("around", 3.0),
            share("off", 3.0),
            share("at_8_bit", 10.0),
            share("at_8_bit", 7.1),
            f"RMS gain, median: {statistics.median(min(row['gain_db']) for row in rows):.1f} dB",
            f"below + 1 dB over the range: {sum(row['rise_db'] < 1.0 for row in rows)}, 8 bits "
            f"{sum(row['rise_8_bit_db'] < 1.0 for row in rows)}",
            f"8 bits lose, median and worst: {statistics.median(loss):.1f}, {max(loss):.1f} dB, less than 3 dB in "
            f"{sum(one < 3.0 for one in loss)}",
            f"reserve kept, least share: {min(row['reserve'] for row in rows):.2f}; whole change kept in "
            f"{sum(row['kept'] == 1.0 for row in rows)}",
            f"CPU s, median and worst: {statistics.median(row['cpu_s'] for row in rows):.1f}, "
            f"{max(row['cpu_s'] for row in rows):.1f}",
        ]
    )


if __name__ == "__main__":
    main()
