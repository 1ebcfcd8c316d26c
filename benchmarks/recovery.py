"""How often the catalogue leads to the optimum: random mechanisms, identified and held against their truth.

Each mechanism is drawn by its seed, its records are simulated with noise, offset and drift, and `identify` is
given these, the catalogue and no stages. It succeeds where the residual sum is not above that at the truth by
more than one sigma squared, every parameter is within 5 of its sigmas of the truth, and every sigma within a
factor 1.5 of the Cramer-Rao bound at the truth. One line of JSON is appended for each; what is in the file
already is not repeated, so a run may be stopped and taken up again. A changed method wants a new file.

    python benchmarks/recovery.py --family 1 --seeds 0:100 [--without slow|sweep] [--workers 2] [--out FILE]
        [--scheduler ADDRESS]
"""

import argparse
import json
import statistics
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from scipy.stats import binomtest

from mechid.identification.computation.parallel import map_tasks
from mechid.identification.computation.workforce import working_on_scheduler
from recovery.campaigns import VARIANTS
from recovery.mechanisms import FAMILIES
from recovery.recovered import recovered

OUT = Path("build/recovery.jsonl")


def main() -> None:
    """Identify what is not in the file yet, and print the table of what was asked for."""
    arguments = _arguments()
    variant = arguments.without or "all"
    keys = [(arguments.family, seed, variant) for seed in range(*arguments.seeds)]
    done = {_key(line): line for line in _lines(arguments.out)}
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    left = [key for key in keys if key not in done]

    def ended(some) -> None:
        for number, line, _ in some:
            done[left[number]] = line
            with arguments.out.open("a") as file:
                file.write(json.dumps(line) + "\n")
            print(told(line), flush=True)

    with working_on_scheduler(arguments.scheduler):
        map_tasks(partial(recovered, arguments.workers), left, 1, ended)
    print(table([done[key] for key in keys]))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--family", type=int, choices=sorted(FAMILIES), default=1)
    parser.add_argument("--seeds", type=_range, default=(0, 100), metavar="A:B", help="from A up to, not with, B")
    parser.add_argument("--without", choices=[name for name in VARIANTS if name != "all"])
    parser.add_argument("--workers", type=int, default=None, help="threads of each identification")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="Dask scheduler; workers need this folder in PYTHONPATH")
    parser.add_argument("--out", type=Path, default=OUT, help=f"file to be continued, {OUT} by default")
    return parser.parse_args()


def _range(text: str) -> tuple[int, int]:
    first, _, last = text.partition(":")
    return int(first), int(last)


def _lines(path: Path) -> Iterator[dict]:
    """Yield what the file holds; a last line that a killed run left unfinished is no line."""
    for text in path.read_text().splitlines() if path.exists() else []:
        try:
            yield json.loads(text)
        except json.JSONDecodeError:
            continue


def _key(line: dict) -> tuple[int, int, str]:
    return line["family"], line["seed"], line["variant"]


def told(line: dict) -> str:
    """Return one mechanism's line of the table."""
    name, error = line["worst"]
    ratio_name, ratio = line["sigma_ratio"]
    verdict = "ok" if line["success"] else "FAILED " + "+".join(line["reasons"])
    short = min(line["horizons_s"].items(), key=lambda item: item[1])
    return (
        f"{line['family']}/{line['variant']:5} {line['seed']:4d}  {line['wall_s']:6.1f} s {line['evaluations']:4d} ev  "
        f"{line['outcome']:13} excess {line['excess']:9.3g}  {name.split('.', 1)[1]} {error:.2g} sigma  "
        f"{ratio_name.split('.', 1)[1]} x{ratio:.2f}  shortest horizon {short[0]} {short[1]:.2f} s  {verdict}"
    )


def table(lines: list[dict]) -> str:
    """Return the summary: success rate with its Clopper-Pearson interval, wall times, every failure."""
    good = sum(line["success"] for line in lines)
    interval = binomtest(good, len(lines)).proportion_ci(0.95, method="exact")
    walls = [line["wall_s"] for line in lines]
    rows = [
        "",
        f"{good} of {len(lines)} recovered, {good / len(lines):.1%}; 95 % interval (Clopper-Pearson) "
        f"{interval.low:.1%} to {interval.high:.1%}",
        f"wall time: median {statistics.median(walls):.1f} s, worst {max(walls):.1f} s",
    ]
    return "\n".join(rows + [told(line) for line in lines if not line["success"]])


if __name__ == "__main__":
    main()
