"""Time a whole command by its parts: what a user waits for between Enter and the prompt.

    python benchmarks/bench_command.py [--benches demo 1/100 2/104] [--repetitions 3] [--first] [--out FILE]

A bench is the demo, or a mechanism of the recovery benchmark (family/seed), whose records, noise included, are written
as files first. Each run is a process of its own on a kernel that is in the cache; `--first` times the first compilation
too, each in a cache of its own. The table gives medians of wall and CPU seconds; on a busy machine only CPU counts.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path

from bench_sweep import RESULTS, machine
from command.benches import write_recovery_bench
from mechid.demos.run import make_bench

CHILD = Path(__file__).parent / "command" / "timed.py"
DEMO = "demo"
VERBS = ["identify", "check", "look", "diagnose", "compare", "budget"]
BYTECODE = {"PYTHONDONTWRITEBYTECODE": "", "PYTHONPYCACHEPREFIX": str(Path(tempfile.gettempdir()) / "mechid-bytecode")}
"""An installed mechid has its bytecode kept; the first run of each command, which is not counted, writes it."""


def main() -> None:
    """Run the benchmark and write its table and its file."""
    arguments = _arguments()
    with tempfile.TemporaryDirectory() as scratch:
        rows = []
        for bench in arguments.benches:
            folder = _bench(bench, Path(scratch) / bench.replace("/", "_"))
            for verb in [verb for verb in arguments.verbs if verb != "budget" or bench == DEMO]:
                command = _command(verb, folder)
                runs = [timed(command, {}) for _ in range(arguments.repetitions + 1)][1:]
                rows.append({"bench": bench, "verb": verb, "runs": runs})
                print(told(rows[-1]), flush=True)
        firsts = [first_compilation(Path(scratch) / f"cache_{k}") for k in range(arguments.first)]
    if firsts:
        print(f"first compilation: {statistics.median(run['cpu_s'] for run in firsts):.2f} s CPU")
    path = arguments.out or RESULTS / f"command-{datetime.now(UTC):%Y%m%dT%H%M%S}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({"machine": machine(), "commands": rows, "first": firsts}, indent=1) + "\n")
    print(f"written: {path}")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--benches", nargs="*", default=[DEMO, "1/100"], help="demo, or family/seed")
    parser.add_argument("--verbs", nargs="+", default=VERBS, choices=VERBS, help="in this order; the fit comes first")
    parser.add_argument("--repetitions", type=int, default=3)
    parser.add_argument("--first", type=int, default=0, metavar="N", help="so many first compilations")
    parser.add_argument("--out", type=Path, help="file to write; default: benchmarks/results/")
    return parser.parse_args()


def _bench(name: str, folder: Path) -> Path:
    """Write the files of a bench, and return its folder."""
    if name == DEMO:
        make_bench(folder, 0)
    else:
        family, _, seed = name.partition("/")
        write_recovery_bench(folder, int(family), int(seed))
    return folder


def _command(verb: str, folder: Path) -> list[str]:
    """Return the words of a command on a bench; `identify` writes beside the records, where the others read its fit."""
    if verb == "compare":
        copy = folder.with_name(f"{folder.name}_copy")
        shutil.copytree(folder, copy, dirs_exist_ok=True)
        return [verb, str(folder), str(copy)]
    given = {"look": "campaign.toml", "budget": "budget.toml"}.get(verb)
    out = {"identify": folder, "check": None}.get(verb, folder / verb)
    return [verb, str(folder / given if given else folder), *(["--out", str(out)] if out else [])]


def timed(command: list[str], environment: Mapping[str, str]) -> dict:
    """Run a command of mechid in a process of its own; seconds by part, and of all of it."""
    with tempfile.NamedTemporaryFile(suffix=".json") as file:
        whole, around = [sys.executable, CHILD, file.name, *command], {**os.environ, **BYTECODE, **environment}
        done = subprocess.run(whole, env=around, capture_output=True, text=True, check=False)
        if done.returncode not in (0, 5):
            raise SystemExit(done.stderr)
        return json.loads(Path(file.name).read_text())


def first_compilation(cache: Path) -> dict:
    """Time what compiling the paper's kernel takes where the cache is empty."""
    found = timed(["kernel", "--source"], {"MECHID_CACHE": str(cache)})
    return {"cpu_s": found["parts"]["kernel"]["cpu_s"], "wall_s": found["parts"]["kernel"]["wall_s"]}


def told(row: dict) -> str:
    """Return the lines of a command: median wall and CPU seconds of each part."""
    parts = list(dict.fromkeys(name for run in row["runs"] for name in run["parts"]))
    figures = statistics.median(run["whole"]["figures_cpu_s"] for run in row["runs"])
    whole = _medians([run["whole"] for run in row["runs"]])
    lines = [f"{row['verb']} {row['bench']}: {whole}, and {figures:.2f} s CPU of what draws figures"]
    for name in parts:
        lines.append(f"    {name:24} {_medians([run['parts'][name] for run in row['runs'] if name in run['parts']])}")
    lines.append(f"    {'the rest':24} {_medians([rest(run) for run in row['runs']])}")
    return "\n".join(lines)


def rest(run: dict) -> dict:
    """Return the seconds of a run that are in no part."""
    parts = run["parts"].values()
    return {key: run["whole"][key] - sum(part[key] for part in parts) for key in ("wall_s", "cpu_s")}


def _medians(runs: list[dict]) -> str:
    wall, cpu = (statistics.median(run[key] for run in runs) for key in ("wall_s", "cpu_s"))
    return f"{wall:6.2f} s wall {cpu:6.2f} s CPU"


if __name__ == "__main__":
    main()
