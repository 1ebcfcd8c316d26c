"""Benches made by other people's simulators, to be identified from the catalogue.

    python benchmarks/foreign_benches.py heyoka --out FOLDER [--python PYTHON]    # a Python that has heyoka
    python benchmarks/foreign_benches.py ngspice --out FOLDER                     # the program ngspice
    python benchmarks/foreign_benches.py heyoka --out FOLDER --compare            # its records beside mechid's own
    python benchmarks/foreign_benches.py heyoka --out FOLDER --fit FIT            # a fit beside the truth

then `mechid identify FOLDER --out FIT`. Records that are in FOLDER already are not made again.
"""

import argparse
import json
import sys
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import chi2

from foreign import by_heyoka, by_ngspice
from foreign.benches import RUNS, TRUTH_NAME, make_bench
from foreign.values import TRUTH
from mechid.campaign import catalogue_mechanism, load_campaign
from recovery.campaigns import Test, torque_of


def main() -> None:
    """Make a bench, compare it, or hold a fit of it against the truth."""
    arguments = _arguments()
    if arguments.compare:
        compare(arguments.out)
    elif arguments.fit:
        judge(arguments.out, arguments.fit)
    elif arguments.simulator == "heyoka":
        version, make = by_heyoka.version(arguments.python), partial(by_heyoka.torque_of, arguments.python)
        make_bench(arguments.out, "heyoka", version, make, {}, arguments.seed)
    else:
        make_bench(
            arguments.out, "ngspice", by_ngspice.version(), by_ngspice.torque_of, by_ngspice.FACTS, arguments.seed
        )


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("simulator", choices=["heyoka", "ngspice"])
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER", help="the bench, to be continued")
    parser.add_argument("--python", default=sys.executable, help="that has heyoka")
    parser.add_argument("--seed", type=int, default=0, help="of the noise")
    parser.add_argument("--compare", action="store_true", help="only compare the records with mechid's simulation")
    parser.add_argument("--fit", type=Path, metavar="DIR", help="only hold a fit against the truth")
    return parser.parse_args()


def compare(folder: Path) -> None:
    """Print for each record how far it is from mechid's own simulation with the true values, RMS over RMS."""
    truth = catalogue_mechanism().with_values(TRUTH)
    campaign = load_campaign(folder)
    for name, (_, seconds) in RUNS.items():
        measured = np.loadtxt(folder / f"{name}.csv", delimiter=",", skiprows=1, usecols=2)
        modelled = torque_of(truth, Test(campaign.record(name).command, seconds))
        off = modelled - measured
        lost = np.flatnonzero(np.abs(off) > 0.01 * measured.std())
        where = f"first 1 % of RMS off at {lost[0] / 1e4:.4f} s" if lost.size else "nowhere 1 % of RMS off"
        print(f"{name:10} {np.sqrt(np.mean(off**2)) / np.sqrt(np.mean(measured**2)):.2e} of the RMS, {where}")


def judge(folder: Path, fit: Path) -> None:
    """Print grade, share followed, and each parameter beside the truth in its standard errors."""
    truth = json.loads((folder / TRUTH_NAME).read_text())["parameters"]
    told = json.loads((fit / "estimate.json").read_text())
    records = told["records"]
    print(f"grade {told['grade']}, {told['outcome']['code']}, {told['provenance']['wall_time_s']:.1f} s")
    for name, one in records.items():
        print(
            f"{name:10} residual {one['residual_rms']:.4g} N m RMS of noise {one['noise_known']:.4g}, "
            f"horizon {one['horizon_s']:.4g} s"
        )
    offs = {name: _off(told["parameters"][name], true) for name, true in truth.items()}
    for name, true in truth.items():
        found, off = told["parameters"][name], offs[name]
        z = f"{off / found['std_error']:7.2f}" if found["std_error"] else f"   none ({found['status']})"
        print(f"{name:32} {found['value']:12.6g} true {true:10.6g}  off {100 * off / abs(true):8.3f} %  z {z}")
    names = [name for name in told["correlation"]["names"] if name in offs]
    at = [told["correlation"]["names"].index(name) for name in names]
    z = np.array([offs[name] / told["parameters"][name]["std_error"] for name in names])
    squared = z @ np.linalg.solve(np.array(told["correlation"]["matrix"])[np.ix_(at, at)], z)
    print(
        f"all together: squared distance {squared:.1f} of {len(names)} parameters, p {chi2.sf(squared, len(names)):.3g}"
    )


def _off(found: Mapping[str, Any], true: float) -> float:
    """Return value less truth, of angles on the circle."""
    off = found["value"] - true
    return (off + 180.0) % 360.0 - 180.0 if found["unit"] == "deg" else off


if __name__ == "__main__":
    main()
