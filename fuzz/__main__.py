"""Make inputs, change them, and have mechid read them, until nothing new is reached.

    python -m fuzz [--inputs 200000] [--seconds S] [--kinds csv,hdf5] [--counts build/fuzz.json] [--again] [--branches]

It goes on from its file of counts; a changed builder wants a new one. Ctrl-C and a kill lose a second. `--again` tries
the inputs that were findings once more and counts what they are now, `--branches` prints what nothing has reached.
"""

import argparse
import shutil
import sys
import time
from pathlib import Path

from fuzz import branches
from fuzz.counts import LAST, Counts
from fuzz.kinds import KINDS
from fuzz.worker import Worker

COUNTS = Path("build/fuzz.json")
BATCH = 25


def main() -> int:
    """Try inputs, and print the table; 1 where there is a finding."""
    given = _arguments()
    counts = Counts.read(given.counts)
    kept = given.counts.parent / "found"
    kept.mkdir(parents=True, exist_ok=True)
    kinds = tuple(kind for kind in KINDS if not given.kinds or kind.name in given.kinds.split(","))
    worker = Worker(kinds, frozenset(counts.taken), kept)
    try:
        if given.again:
            _again(counts, worker)
        else:
            _on(counts, worker, given, time.monotonic() + given.seconds)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
    finally:
        worker.end()
        counts.write(given.counts)
    every = branches.all_branches()
    print(counts.table(every))
    if given.branches:
        print("\n".join(sorted(every.difference(counts.taken))))
    return 1 if counts.findings else 0


def _on(counts: Counts, worker: Worker, given: argparse.Namespace, until: float) -> None:
    """Try batches of the kinds in turn, each as often as it weighs, until there is enough or no time is left."""
    turns = [kind for kind in worker.kinds.values() for _ in range(kind.weight)]
    written = time.monotonic()
    while time.monotonic() < until and (counts.total < given.inputs or counts.new_of_the_last):
        kind = min(turns, key=lambda one: counts.next(one.name) / one.weight).name
        first = counts.next(kind)
        for tried in worker.tried(kind, range(first, first + BATCH)):
            counts.add(kind, tried)
        if time.monotonic() - written > 1.0:
            counts.write(given.counts)
            written = time.monotonic()
            last = f"{counts.new_of_the_last} new branches in the last {LAST}, {len(counts.findings)} findings"
            print(f"\r{counts.total} inputs, {last}", end="", file=sys.stderr, flush=True)


def _again(counts: Counts, worker: Worker) -> None:
    """Try what was a finding once more, and count what it is now."""
    for where in list(counts.findings):
        kind = where.partition(" ")[0]
        if kind not in worker.kinds:
            continue
        for number in counts.forget(where):
            shutil.rmtree(worker.kept / f"{kind}-{number}", ignore_errors=True)
            for tried in worker.tried(kind, range(number, number + 1)):
                counts.add(kind, tried)
                print(kind, number, tried.outcome.what, tried.outcome.words[:200])


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="fuzz", description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=200_000, help="at least so many, 200000 by default")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="at most so long")
    parser.add_argument(
        "--kinds", default="", help="only these, with commas between: " + ", ".join(k.name for k in KINDS)
    )
    parser.add_argument("--counts", type=Path, default=COUNTS, help=f"file to go on from, {COUNTS} by default")
    parser.add_argument("--again", action="store_true", help="try earlier findings once more")
    parser.add_argument("--branches", action="store_true", help="print the branches that nothing has taken")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
