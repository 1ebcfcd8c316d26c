"""What `mechid check` and `mechid identify` say of campaigns in which one thing is wrong.

    python benchmarks/wrong_campaigns.py [--command check|identify] [--only NAME ...] [--folder DIR] [--out FILE]
                                         [--cpu-limit SECONDS] [--from-truth] [--short]
                                         [--near-truth]

Each campaign is a synthetic bench in which one thing is declared or recorded wrongly (`wrong.cases`). Counted is
whether a line that names it is among the first three of the output, or anywhere in it. Of `identify`, from the
catalogue, also how far its estimates are off. A confident wrong answer is a fit of grade A or B that has an estimate
more than 5 of its standard errors and 2 % off, where no line names the cause; of an angle, 2 % are those of half a
turn. What is in --out already is not run again; what reaches its limit ends as interrupted. With --near-truth nothing
is searched: all is fitted jointly from the true values, records as declared, to see what a fit says of itself there.
"""

import argparse
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from mechid.campaign.bench import TRUTH
from mechid.writing import write_atomically
from wrong.bench import Files, right_files, shorten
from wrong.cases import Case, cases

FIRST = 3
NEAR = """
import sys
from pathlib import Path
from mechid import identify, load_campaign
from mechid.campaign.bench import TRUTH
from mechid.identification.result.estimate_file import write_estimate
from mechid.errors import MechidError
try:
    campaign = load_campaign(sys.argv[1])
except MechidError as error:
    print(error)
    sys.exit(error.exit_code)
free = {p.name for p in campaign.mechanism.free}
limits = campaign.mechanism.parameters
near = {n: min(max(v, limits[n].min), limits[n].max) for n, v in TRUTH.items() if n in free}
fit = identify(campaign, workers=1, near=near)
Path(sys.argv[2]).mkdir(parents=True, exist_ok=True)
write_estimate(fit, Path(sys.argv[2]) / "estimate.json")
print(*(reason.text for reason in fit.reasons), *fit.warnings, sep="\\n")
"""
"""A fit without a search, of a campaign into a folder."""
CONFIDENT, SHARE = 5.0, 0.02


def main() -> None:
    """Run the cases and print a line for each, then the counts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--command", choices=("check", "identify"), default="check")
    parser.add_argument("--only", nargs="*", default=[], metavar="NAME")
    parser.add_argument("--folder", type=Path, help="where the campaigns are kept; else a temporary one")
    parser.add_argument("--from-truth", action="store_true", help="identify from the true values, for less time")
    parser.add_argument("--near-truth", action="store_true", help="one joint fit from the true values, no search")
    parser.add_argument("--short", action="store_true", help="records of 6 s in all instead of 18")
    parser.add_argument("--cpu-limit", type=int, default=3600, help="CPU seconds of one run", metavar="SECONDS")
    parser.add_argument("--out", type=Path, help="JSON of all rows, taken up again")
    arguments = parser.parse_args()
    if arguments.short:
        shorten()
    resource.setrlimit(resource.RLIMIT_CPU, (arguments.cpu_limit, resource.RLIM_INFINITY))
    rows = json.loads(arguments.out.read_text()) if arguments.out and arguments.out.exists() else {}
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.folder or Path(temporary)
        for case in cases():
            if arguments.only and case.name not in arguments.only:
                continue
            if case.name not in rows or arguments.only:
                command = "near" if arguments.near_truth else arguments.command
                rows[case.name] = judged(case, folder, command, from_truth=arguments.from_truth)
                if arguments.out:
                    write_atomically(arguments.out, json.dumps(rows, indent=1) + "\n")
            _print(case, rows[case.name])
    counted = [rows[case.name] for case in cases() if case.name in rows]
    for said in ("first lines", "later", "not named"):
        print(f"{said}: {sum(row['named'] == said for row in counted)} of {len(counted)}")
    grades = [row["grade"] for row in counted if "grade" in row]
    print(", ".join(f"{grades.count(grade)} of grade {grade}" for grade in sorted(set(grades))))
    print(f"confident wrong answers: {sum(map(is_confident_and_wrong, counted))}")


def judged(case: Case, folder: Path, command: str, *, from_truth: bool = False) -> dict[str, Any]:
    """Write a wrong campaign, run a command on it, and return what it said."""
    right = right_files(folder / "right")
    files = Files()
    case.make(files)
    number = [one.name for one in cases()].index(case.name)
    place = folder / f"{number:02d}"  # a name of its own would be found in what is printed
    campaign = files.write(place, right, from_truth=from_truth)
    result = campaign / "result"
    (result / "estimate.json").unlink(missing_ok=True)
    asked = {
        "near": ["-c", NEAR, str(campaign), str(result)],
        "identify": ["-m", "mechid", "identify", str(campaign), "--out", str(result)],
        "check": ["-m", "mechid", "check", str(campaign)],
    }[command]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, *asked], capture_output=True, text=True, check=False, env={**os.environ, "COLUMNS": "100000"}
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    lines = [line for line in (done.stdout or done.stderr).splitlines() if line]
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {
        "kind": case.kind,
        "exit": done.returncode,
        "named": named(case, lines),
        "cpu_s": round(cpu, 2),
        "lines": lines[:FIRST],
        **estimated(result),
    }


def named(case: Case, lines: list[str]) -> str:
    """Return where the cause is named: in the first lines, later, or not at all."""
    found = [i for i, line in enumerate(lines) if re.search(case.words, line)]
    return "not named" if not found else "first lines" if found[0] < FIRST else "later"


def estimated(result: Path) -> dict[str, Any]:
    """Return the grade of a fit, and how far its worst estimate is off in its standard errors."""
    path = result / "estimate.json"
    if not path.exists():
        return {}
    content = json.loads(path.read_text())
    off = {name: _off(name, content["parameters"][name]) for name in TRUTH}
    told = {name: one for name, one in off.items() if one is not None}
    worst = max(told, key=lambda name: told[name][0], default=None)
    return {
        "grade": content["grade"],
        "worst": worst,
        "off": told[worst][0] if worst else None,
        "wrong": {name: one for name, one in told.items() if one[0] > CONFIDENT and one[1] > SHARE},
        "outcome": content["outcome"]["code"],
        "warnings": content["warnings"],
        "missing": [one["name"] for one in content["missing"] or []],
    }


def is_confident_and_wrong(row: dict[str, Any]) -> bool:
    """Tell whether a fit says that it is good, is far off, and nothing that was printed says why."""
    return row.get("grade") in ("A", "B") and bool(row["wrong"]) and row["named"] == "not named"


def _off(name: str, parameter: dict[str, Any]) -> tuple[float, float] | None:
    """Return how many standard errors, and which share of itself, an estimate is off; None where it has no error."""
    if not parameter["std_error"]:
        return None
    off, size = parameter["value"] - TRUTH[name], abs(TRUTH[name])
    if name.endswith("_deg"):
        off, size = 180.0 - (180.0 - off) % 360.0, 180.0
    return abs(off) / float(parameter["std_error"]), abs(off) / size


def _print(case: Case, row: dict[str, Any]) -> None:
    off = "" if row.get("off") is None else f"{row['off']:.1f} ({row['worst']})"
    wrong = "confident and wrong" if is_confident_and_wrong(row) else ""
    cells = (case.kind, case.name, row["exit"], row["named"], row.get("grade", ""), off, wrong, row["cpu_s"])
    print("| " + " | ".join(map(str, cells)) + " |", flush=True)


if __name__ == "__main__":
    main()
