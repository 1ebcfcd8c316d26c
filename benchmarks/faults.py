"""Faults, one after another: a run is killed, interrupted, starved of disk, clock, cache, company or workers.

Each trial ends with the same question: are the numbers those of a run that nobody disturbed, to the bit? And: did the
disturbed one end with the exit code and the line that are promised, and leave nothing half-written? One line of JSON is
appended for each trial; what is in the file already is not repeated, so a run may be stopped and taken up again.

    python benchmarks/faults.py [--only kill,interrupt,...] [--count N] [--seed S] [--out FILE] [--work FOLDER]

A disk that is full, and a cache that cannot be written to, are small file systems of memory where this is run by root;
elsewhere these trials are left out.
"""

import argparse
import json
import sys
import time
from pathlib import Path

from faults.clock import stepped
from faults.cluster import workers
from faults.disks import full, read_only, renames
from faults.explorer import soak
from faults.kills import interrupts, kills
from faults.reference import Reference
from faults.together import one_cache, one_folder

SCENARIOS = {
    "kill": kills,
    "interrupt": interrupts,
    "full": full,
    "rename": renames,
    "clock": stepped,
    "cache": read_only,
    "folder": one_folder,
    "kernels": one_cache,
    "workers": workers,
    "soak": soak,
}
OUT = Path("build/faults.jsonl")


def main() -> int:
    """Do what is not in the file yet; return 1 where a trial found a fault."""
    arguments = _arguments()
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    reference = Reference(arguments.work, arguments.seed)
    for name in arguments.only:
        done = {line["number"] for line in _lines(arguments.out) if line["scenario"] == name}
        for trial in SCENARIOS[name](reference, arguments.count):
            if trial.number in done:
                continue
            began = time.perf_counter()
            found = trial.run()
            line = {"scenario": name, "number": trial.number, "what": trial.what, **found}
            line["seconds"] = round(time.perf_counter() - began, 1)
            with arguments.out.open("a") as file:
                file.write(json.dumps(line) + "\n")
            print(
                f"{name} {trial.number}: {trial.what}: {'as promised' if not line['faults'] else line['faults']}",
                flush=True,
            )
    lines = _lines(arguments.out)
    print(table(lines))
    return int(any(line["faults"] for line in lines))


def table(lines) -> str:
    """Return trials and faults of each scenario."""
    names = [name for name in SCENARIOS if any(line["scenario"] == name for line in lines)]
    rows = [("scenario", "trials", "as promised")]
    for name in names:
        own = [line for line in lines if line["scenario"] == name]
        rows.append((name, str(len(own)), str(sum(not line["faults"] for line in own))))
    return "\n".join(f"{a:10}{b:>8}{c:>13}" for a, b, c in rows)


def _lines(path: Path) -> list[dict]:
    return [json.loads(line) for line in path.read_text().splitlines()] if path.is_file() else []


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", type=_names, default=list(SCENARIOS), metavar="A,B", help=", ".join(SCENARIOS))
    parser.add_argument("--count", type=int, default=None, help="trials of each scenario; its own number without it")
    parser.add_argument("--seed", type=int, default=0, help="of the instants, and of the bench")
    parser.add_argument("--out", type=Path, default=OUT, help=f"file to be continued, {OUT} by default")
    parser.add_argument("--work", type=Path, default=Path("build/faults"), help="folder for the runs")
    return parser.parse_args()


def _names(text: str) -> list[str]:
    names = text.split(",")
    if unknown := set(names) - set(SCENARIOS):
        raise argparse.ArgumentTypeError(f"unknown {', '.join(sorted(unknown))}; there are {', '.join(SCENARIOS)}")
    return names


if __name__ == "__main__":
    sys.exit(main())
