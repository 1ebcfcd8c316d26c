"""Whether error bars hold where the model lacks something: benches with one effect left out, fitted and counted.

Each bench is made by a simulator of its own, from a mechanism and a size of the effect that are drawn; its mechanism
file lacks the effect. The fit starts within 1 % of the truth and goes without a search; with `--catalogue` it is
searched for from the catalogue, as a user's is. With `--sizes hardware` the sizes are those that hardware has, and the
command `mechid identify` makes the search, whose whole CPU time counts. One line of JSON is appended for each fit; what
is in the folder already is not repeated, so a run may be stopped, taken up again, and done in pieces. A changed method
wants a new folder.

    python benchmarks/incomplete_benches.py [--effects NAME ...] [--seeds 0:5] [--halves] [--reference] [--out FOLDER]
    python benchmarks/incomplete_benches.py --catalogue [--effects NAME ...] [--seeds 0:10] [--out FOLDER]
    python benchmarks/incomplete_benches.py --sizes hardware --catalogue [--effects NAME ...] [--pairs] [--seeds 0:6]
    python benchmarks/incomplete_benches.py --sizes hardware --catalogue --make-only --out FOLDER   # benches as files
    python benchmarks/incomplete_benches.py --complete 20 [--out FOLDER]       # of each of five kinds of noise
    python benchmarks/incomplete_benches.py --summary [--out FOLDER]           # of what is there, nothing is fitted
"""

import argparse
import json
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from incomplete.benches import TRUTH_NAME, drawn, make_bench
from incomplete.complete import KINDS, Complete
from incomplete.effects import EFFECTS, NOTHING, effects_of
from incomplete.fits import fitted, half
from incomplete.hardware import HARDWARE, PAIRS
from incomplete.search_summary import said_of, search_table
from incomplete.searches import search_bench
from incomplete.sizes import SIZES, SMALL, Sizes
from incomplete.summary import catalogue_table, complete_table, incomplete_table, told
from mechid.campaign import load_campaign
from mechid.campaign.bench import TRUTH
from recovery.mechanisms import FAMILIES

OUT = Path("build/incomplete")
BENCHES, COMPLETE, SEARCHES = "fits.jsonl", "complete.jsonl", "searches.jsonl"
ESTIMATES = "estimates"
"""Folder of the estimate.json of each search from the catalogue, for `diagnosis_benches.py`."""
CATALOGUE = "catalogue"
"""Part of a bench that is all of it, searched for from the catalogue."""


def main() -> None:
    """Fit what is not in the folder yet, and print the tables of what is."""
    arguments = _arguments()
    out = arguments.out
    out.mkdir(parents=True, exist_ok=True)
    if arguments.make_only:
        make(arguments.sizes, arguments.effects, range(*arguments.seeds), out, catalogue=arguments.catalogue)
        return
    if arguments.sizes is not SMALL:
        if not arguments.summary:
            searches(out / SEARCHES, arguments, range(*arguments.seeds))
        print(search_table(list(read(out / SEARCHES))))
        return
    if not arguments.summary and not arguments.complete:
        parts = ["whole", *(["first", "second"] if arguments.halves else []), *(["reference"] * arguments.reference)]
        parts = [CATALOGUE] if arguments.catalogue else parts
        benches(out / BENCHES, arguments.effects, range(*arguments.seeds), parts)
    if arguments.complete:
        completes(out / COMPLETE, range(arguments.complete))
    lines = list(read(out / BENCHES))
    searched, near = ([line for line in lines if (line["part"] == CATALOGUE) is chosen] for chosen in (True, False))
    if searched and not arguments.complete:
        print(catalogue_table(searched))
    if near and not arguments.complete:
        print(incomplete_table(near))
    lines = list(read(out / COMPLETE))
    if lines and (arguments.complete or arguments.summary):
        print(complete_table(lines))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--effects",
        nargs="+",
        default=[],
        metavar="NAME",
        help=f"{NOTHING}, or of {', '.join(EFFECTS)}, of hardware {', '.join(HARDWARE)}; several at once joined by +; "
        "all without it",
    )
    parser.add_argument("--pairs", action="store_true", help="the pairs of effects in the hardware table")
    parser.add_argument("--sizes", choices=SIZES, default="small", help="family of benches, small by default")
    parser.add_argument("--workers", type=int, default=1, help="threads of a search of benches of hardware sizes")
    parser.add_argument("--make-only", action="store_true", help="only write the benches, a folder each")
    parser.add_argument("--seeds", type=seeds_from, default=(0, 5), metavar="A:B", help="from A up to, not with, B")
    parser.add_argument("--halves", action="store_true", help="fit the first and the second half of each record too")
    parser.add_argument("--reference", action="store_true", help="fit each bench without its effect too")
    parser.add_argument("--catalogue", action="store_true", help="search from the catalogue")
    parser.add_argument("--complete", type=int, default=0, metavar="N", help="fit N complete campaigns of each noise")
    parser.add_argument("--summary", action="store_true", help="only print what the folder holds")
    parser.add_argument("--out", type=Path, default=OUT, help=f"folder to be continued, {OUT} by default")
    arguments = parser.parse_args()
    if arguments.sizes != "small" and not (arguments.catalogue or arguments.summary):
        parser.error(f"benches of {arguments.sizes} sizes are searched for from the catalogue: add --catalogue")
    arguments.sizes = SIZES[arguments.sizes]
    asked = dict.fromkeys([*arguments.effects, *PAIRS * arguments.pairs])
    arguments.effects = list(asked or arguments.sizes.effects)
    try:
        for name in arguments.effects:
            effects_of(name, arguments.sizes.effects)
    except ValueError as wrong:
        parser.error(str(wrong))
    return arguments


def seeds_from(text: str) -> tuple[int, int]:
    """Return the first seed and the one behind the last of an option, as "0:5"."""
    first, _, last = text.partition(":")
    return int(first), int(last)


def read(path: Path) -> Iterator[dict]:
    """Yield what a file holds; a last line that a killed run left unfinished is no line."""
    for text in path.read_text().splitlines() if path.exists() else []:
        try:
            yield json.loads(text)
        except json.JSONDecodeError:
            continue


def append(path: Path, line: dict, said: Callable[[dict], str] = told) -> None:
    """Append a line whole and say it; one that a killed run left unfinished before it is ended first."""
    unfinished = path.exists() and path.stat().st_size and not path.read_bytes().endswith(b"\n")
    with path.open("a") as file:
        file.write("\n" * bool(unfinished) + json.dumps(line) + "\n")
    print(said(line), flush=True)


def make(sizes: Sizes, effects: list[str], seeds: range, out: Path, *, catalogue: bool) -> None:
    """Write each bench that is not whole yet into a folder of its effect and seed."""
    for seed in seeds:
        for effect in effects:
            folder = out / f"{effect}_{seed}"
            if not (folder / TRUTH_NAME).exists():
                make_bench(effect, seed, folder, sizes=sizes, catalogue=catalogue)
                print(folder, flush=True)


def searches(path: Path, arguments: argparse.Namespace, seeds: range) -> None:
    """Search for the benches that the file does not hold, each by the command and from the catalogue."""
    done = {(line["effect"], line["seed"]) for line in read(path)}
    for seed in seeds:
        for effect in arguments.effects:
            if (effect, seed) not in done:
                keep = path.parent / f"{ESTIMATES}-{arguments.sizes.name}" / f"{effect}-{seed}.json"
                append(path, search_bench(effect, seed, arguments.sizes, arguments.workers, keep), said_of)


def benches(path: Path, effects: list[str], seeds: range, parts: list[str]) -> None:
    """Fit the parts of the benches that the file does not hold; seed by seed, so that all effects are there early."""
    done = {(line["effect"], line["seed"], line["part"]) for line in read(path)}
    for seed in seeds:
        for effect in effects:
            missing = [part for part in parts if (effect, seed, part) not in done]
            for line in fits_of(effect, seed, missing, path.parent / ESTIMATES) if missing else ():
                append(path, line)


def fits_of(effect: str, seed: int, parts: list[str], keep: Path) -> Iterator[dict]:
    """Yield a line for each part of a bench; estimates of searches are kept in a folder."""
    for with_effect in (True, False):
        chosen = [part for part in parts if (part != "reference") == with_effect]
        if not chosen:
            continue
        with tempfile.TemporaryDirectory() as folder:
            bench = make_bench(effect, seed, Path(folder), with_effect=with_effect)
            campaign = load_campaign(bench.folder)
        near = {p.name: p.value for p in campaign.mechanism.free}
        for part in chosen:
            searched = part == CATALOGUE
            records = half(campaign, part) if part in ("first", "second") else campaign
            records = replace(campaign, mechanism=FAMILIES[1].catalogue()) if searched else records
            how = (None, None, keep / f"{effect}-{seed}.json") if searched else (near, 1)
            yield {
                "effect": effect,
                "seed": seed,
                "part": part,
                "size": drawn(effect, seed)[1],
                **fitted(records, bench.truth, *how),
            }


def completes(path: Path, draws: range) -> None:
    """Fit the complete campaigns that the file does not hold, draw by draw."""
    done = {(line["noise"], line["draw"]) for line in read(path)}
    made = Complete()
    for draw in draws:
        for kind in KINDS:
            if (kind, draw) not in done:
                campaign = made.campaign(kind, draw)
                append(path, {"noise": kind, "draw": draw, **fitted(campaign, TRUTH, TRUTH)})


if __name__ == "__main__":
    main()
