"""Whole lab benches: how many are identified from the catalogue, how far, how soon, and how honestly.

Each bench is drawn by its seed (`lab.benches`): some twenty free parameters, a table with a resonance and a filter, a
trigger that scatters, a clock that is off, mains, 16-bit steps, six components, a tachometer, a clipped record, a sweep
of 40 s. One line of JSON is appended for each fit; what the folder holds already is not repeated. A changed method
wants a new folder.

    python benchmarks/lab_benches.py --seeds 0:12 --out FOLDER          # from the catalogue
    python benchmarks/lab_benches.py --seeds 0:12 --out FOLDER --near   # horizons grown from within 10 % of the truth
    python benchmarks/lab_benches.py --seeds 0:3 --out FOLDER --make-only
"""

import argparse
import math
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from incomplete_benches import append, read, seeds_from
from lab.benches import Bench, make_bench, near_truth
from mechid.campaign import load_campaign
from mechid.identification.computation.progress import Progress
from mechid.identification.identify import identify, identify_from
from mechid.identification.result.fit import Fit

OUT = Path("build/lab")
LINES = "lab.jsonl"
NEAR_SHARE = 0.1
"""How far from the truth a near start lies at most, as a share of each value."""
STATED = 3.0
"""Stated standard errors within which a parameter counts as found."""
FOLLOWED = 99.9
"""Per cent of a record from which on it counts as followed: single windows of misfit are judged by mechid."""


def main() -> None:
    """Fit what is not in the folder yet, and print what is."""
    arguments = _arguments()
    out = arguments.out
    out.mkdir(parents=True, exist_ok=True)
    start = "near" if arguments.near else "catalogue"
    done = {(line["seed"], line["start"]) for line in read(out / LINES)}
    for seed in range(*arguments.seeds):
        if arguments.make_only:
            print(make_bench(seed, out / f"lab_{seed}").folder, flush=True)
        elif (seed, start) not in done:
            append(out / LINES, fitted(seed, start, arguments.workers), told)
    lines = list(read(out / LINES))
    for one in ("catalogue", "near"):
        if some := [line for line in lines if line["start"] == one]:
            print(summary(some))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=seeds_from, default=(0, 12), metavar="A:B", help="from A up to, not with, B")
    parser.add_argument("--near", action="store_true", help="start within 10 %% of the truth, without a multi-start")
    parser.add_argument("--make-only", action="store_true", help="write the benches as folders, and fit none")
    parser.add_argument("--workers", type=int, default=1, help="threads of each fit")
    parser.add_argument("--out", type=Path, default=OUT, help=f"folder to be continued, {OUT} by default")
    return parser.parse_args()


def fitted(seed: int, start: str, workers: int) -> dict[str, Any]:
    """Return the line of a bench: its fit from the catalogue, or from near the truth."""
    with tempfile.TemporaryDirectory() as folder:
        bench = make_bench(seed, Path(folder))
        campaign = load_campaign(bench.folder)
    began, began_cpu = time.perf_counter(), time.process_time()
    if start == "near":
        near = near_truth(bench, campaign, NEAR_SHARE)
        fit = identify_from(campaign, near, workers=workers, listener=_show)
    else:
        fit = identify(campaign, workers=workers, listener=_show)
    wall, cpu = time.perf_counter() - began, time.process_time() - began_cpu
    return {"seed": seed, "start": start, "cpu_s": cpu, "wall_s": wall, **judged(fit, bench)}


def _show(progress: Progress) -> None:
    """Say on stderr where a fit stands."""
    print(f"  {progress.elapsed_s:.0f} s: {progress.stage}, {progress.line}", file=sys.stderr, flush=True)


def judged(fit: Fit, bench: Bench) -> dict[str, Any]:
    """Return what is counted of a fit: what it follows, its grade, its errors in its own sigmas, what it names."""
    followed = {
        name: min(channel.followed_percent for channel in record.channels.values())
        for name, record in fit.records.items()
    }
    errors = {name: _in_sigmas(fit, name, true) for name, true in bench.truth.items()}
    return {
        "grade": str(fit.grade),
        "outcome": fit.outcome.code,
        "reasons": [str(reason.cause) for reason in fit.reasons],
        "followed": followed,
        "records_followed": sum(percent >= FOLLOWED for percent in followed.values()),
        "errors": errors,
        "off": {name: fit.parameters[name].value / true - 1.0 for name, true in bench.truth.items()},
        "own": {name: _in_sigmas(fit, name, true) for name, true in bench.own.items() if name in fit.parameters},
        "named": [one.name for one in fit.missing],
        "substeps": fit.provenance["substeps"],
        "warnings": list(fit.warnings),
    }


def _in_sigmas(fit: Fit, name: str, true: float) -> float | None:
    """Return the error of a value in its stated standard errors, a phase's the short way round; None without one."""
    found = fit.parameters[name]
    error = found.value - true
    if found.unit == "deg":
        error = (error + 180.0) % 360.0 - 180.0
    return error / found.std_error if found.std_error else None


def _worst(line: Mapping[str, Any]) -> tuple[str, float]:
    known = {name: abs(z) for name, z in line["errors"].items() if z is not None}
    name = max(known, key=lambda one: known[one], default="")
    return name, known.get(name, math.nan)


def _within(line: Mapping[str, Any]) -> int:
    return sum(z is not None and abs(z) <= STATED for z in line["errors"].values())


def told(line: Mapping[str, Any]) -> str:
    """Return a line in words."""
    name, z = _worst(line)
    records = f"{line['records_followed']} of {len(line['followed'])} records"
    parameters = f"{_within(line)} of {len(line['errors'])} within {STATED:g} sigma, worst {z:.2g} ({name})"
    named = ", ".join(line["named"]) or "nothing"
    return (
        f"lab {line['seed']} from {line['start']}: grade {line['grade']}, {records}, {line['cpu_s']:.0f} s CPU, "
        f"{line['wall_s']:.0f} s; {parameters}; named: {named}"
    )


def summary(lines: list[dict[str, Any]]) -> str:
    """Return a table of the benches of one kind of start, and how many are found."""
    good = [line for line in lines if line["grade"] in ("A", "B") and line["records_followed"] == len(line["followed"])]
    inside, all_of = sum(map(_within, lines)), sum(len(line["errors"]) for line in lines)
    return "\n".join(
        [
            *map(told, sorted(lines, key=lambda line: line["seed"])),
            f"from {lines[0]['start']}: {len(good)} of {len(lines)} followed to their ends with grade A or B; "
            f"{inside} of {all_of} parameters within {STATED:g} stated sigma",
        ]
    )


if __name__ == "__main__":
    main()
