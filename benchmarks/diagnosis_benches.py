"""Whether `mechid diagnose` names what a mechanism file lacks: benches with no, one or two effects left out.

Each bench is that of `incomplete_benches.py`, searched for from the catalogue; where that has kept an estimate it is
taken up, else the search comes first. With --complete it goes the way of `mechid identify --complete`, from the
catalogue to the fit with what is proposed. One line of JSON is appended for each bench; what is in the folder already
is not repeated, so a run may be stopped, taken up again, and done in pieces.

    python benchmarks/diagnosis_benches.py --drawn 0:60 [--complete] [--fits FOLDER] [--out FOLDER]
    python benchmarks/diagnosis_benches.py --effects NAME ... --seeds 0:10 [--complete] [--fits FOLDER] [--out FOLDER]
    python benchmarks/diagnosis_benches.py --summary [--out FOLDER]
"""

import argparse
import math
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from incomplete.benches import make_bench
from incomplete.effects import EFFECTS, NOTHING, effects_of
from incomplete.names import entries_of, false_names, is_exact, names_of
from incomplete.summary import errors_of, rms
from incomplete_benches import ESTIMATES, append, read, seeds_from
from mechid.campaign import Campaign, load_campaign
from mechid.identification.diagnosis.diagnosis import Diagnosis, diagnose
from mechid.identification.identify import identify
from mechid.identification.result.estimate_file import write_estimate
from mechid.identification.result.fit import Fit
from mechid.identification.result.fit_file import read_fit
from mechid.identification.result.grade import Grade
from mechid.identification.result.missing_effects import Missing
from mechid.identification.run import Companion, IdentifyRun, fit_completed_mechanism, search_and_diagnose
from recovery.mechanisms import FAMILIES

OUT = Path("build/diagnosis")
LINES = "diagnoses.jsonl"
DRAWN = [name for name, effect in EFFECTS.items() if effect.in_library and name != "quantisation"]
FIRST_SEED = 1000
"""Of the benches that are drawn: no other benchmark uses them."""
ONE_LAW = {"stribeck", "load_dependent_friction"}
"""Laws of one friction table, of which a mechanism file has one."""
NEAR_PERCENT, NEAR_DEG, NEAR_SIGMA = 2.0, 2.0, 5.0


def drawn(number: int) -> tuple[str, int]:
    """Return effect and seed of a bench: none, one or two effects of the library that may stand together."""
    rng = np.random.default_rng((FIRST_SEED, number))
    for _ in range(int(1e3)):
        chosen = sorted(rng.choice(DRAWN, size=rng.integers(1, 3), replace=False).tolist())
        kinds = {"law" if name in ONE_LAW else name.removesuffix("_between") for name in chosen}
        if len(kinds) == len(chosen):
            return "+".join(chosen), FIRST_SEED + number
    raise AssertionError("no two effects stand together")


def main() -> None:
    """Diagnose what is not in the folder yet, and print the tables of what is."""
    arguments = _arguments()
    arguments.out.mkdir(parents=True, exist_ok=True)
    path = arguments.out / LINES
    done = {(line["effect"], line["seed"]): line for line in read(path)}
    for effect, seed in [] if arguments.summary else _asked(arguments):
        before = done.get((effect, seed))
        if before is None or (arguments.complete and "completed" not in before):
            append(path, diagnosed(effect, seed, arguments.fits or arguments.out, complete=arguments.complete), said)
    lines = list({(line["effect"], line["seed"]): line for line in read(path)}.values())
    if lines:
        print(table(lines))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drawn", type=seeds_from, default=(0, 0), metavar="A:B", help="benches drawn, from A to B")
    parser.add_argument(
        "--effects",
        nargs="+",
        type=effect_named,
        default=[],
        metavar="NAME",
        help=f"{NOTHING}, or of {', '.join(EFFECTS)}; several at once joined by +",
    )
    parser.add_argument("--seeds", type=seeds_from, default=(0, 1), metavar="A:B", help="of --effects")
    parser.add_argument("--complete", action="store_true", help="from the catalogue to the fit with what is proposed")
    parser.add_argument("--fits", type=Path, help="folder of incomplete_benches.py, whose estimates are taken up")
    parser.add_argument("--summary", action="store_true", help="only print what the folder holds")
    parser.add_argument("--out", type=Path, default=OUT, help=f"folder to be continued, {OUT} by default")
    return parser.parse_args()


def effect_named(text: str) -> str:
    """Return a bench's effect as an option names it."""
    effects_of(text)
    return text


def _asked(arguments: argparse.Namespace) -> Iterator[tuple[str, int]]:
    yield from (drawn(number) for number in range(*arguments.drawn))
    yield from ((effect, seed) for seed in range(*arguments.seeds) for effect in arguments.effects)


def diagnosed(effect: str, seed: int, fits: Path, *, complete: bool) -> dict[str, Any]:
    """Return what a diagnosis of a bench says and what it took, and what the completed mechanism's fit is."""
    with tempfile.TemporaryDirectory() as folder:
        bench = make_bench(effect, seed, Path(folder))
        campaign = replace(load_campaign(bench.folder), mechanism=FAMILIES[1].catalogue())
    line = {"effect": effect, "seed": seed, "size": dict(bench.size)}
    began, began_cpu = time.perf_counter(), time.process_time()
    if complete:
        fit, found = search_and_diagnose(campaign, IdentifyRun(), Companion())
    else:
        fit, line["search_s"] = _fit_of(campaign, fits / ESTIMATES / f"{effect}-{seed}.json")
        began, began_cpu = time.perf_counter(), time.process_time()
        found = None if fit.grade is Grade.FAILED else diagnose(fit)
    line |= {
        "grade": str(fit.grade),
        "wall_s": time.perf_counter() - began,
        "cpu_s": time.process_time() - began_cpu,
    }
    if found is None:
        return {**line, "missing": [], "words": "the fit has failed", "completed": None}
    line |= _said_of(found)
    return {**line, "completed": _completed(fit, found, bench.truth)} if complete else line


def _fit_of(campaign: Campaign, path: Path) -> tuple[Fit, float | None]:
    """Return the fit in a file, made where there is none, and how long that took."""
    if path.exists():
        return read_fit(path, campaign), None
    began = time.perf_counter()
    fit = identify(campaign)
    took = time.perf_counter() - began
    path.parent.mkdir(parents=True, exist_ok=True)
    write_estimate(fit, path)
    return read_fit(path, campaign), took


def _said_of(found: Diagnosis) -> dict[str, Any]:
    return {
        "missing": [_entry(one) for one in found.missing],
        "words": found.words,
        "over_noise": found.over_noise,
        "unexplained": found.unexplained,
        "tried": [one.name for one in found.tried],
    }


def _entry(one: Missing) -> dict[str, Any]:
    parameters = {name: [p.value, p.std_error] for name, p in one.parameters.items()}
    return {
        "name": one.name,
        "aliases": list(one.aliases),
        "chi_square": one.chi_square,
        "share": one.share,
        "parameters": parameters,
    }


def _completed(fit: Fit, found: Diagnosis, truth: Any) -> dict[str, Any]:
    """Return grade, reasons, and parameters beside the truth, after the mechanism has what is proposed."""
    began, began_cpu = time.perf_counter(), time.process_time()
    if found.mechanism is not None:
        fit = fit_completed_mechanism(replace(fit.required_campaign, mechanism=found.mechanism), found, IdentifyRun())
    estimates = {name: fit.parameters[name] for name in truth}
    own = {
        name: {"truth": truth[name], "value": p.value, "unit": p.unit, "std_error": p.std_error}
        for name, p in estimates.items()
    }
    took = {"wall_s": time.perf_counter() - began, "cpu_s": time.process_time() - began_cpu}
    return {"grade": str(fit.grade), "reasons": [one.to_dict() for one in fit.reasons], **took, "parameters": own}


def is_near(done: dict[str, Any]) -> bool:
    """Tell whether all parameters of a completed fit are within 5 standard errors and 2 % (2 deg) of the truth."""
    return all(abs(z) <= NEAR_SIGMA for _, z in errors_of(done)) and all(map(_close, done["parameters"].values()))


def _close(p: dict[str, Any]) -> bool:
    if p["unit"] == "deg":
        return abs((p["value"] - p["truth"] + 180.0) % 360.0 - 180.0) <= NEAR_DEG
    return abs(p["value"] - p["truth"]) <= NEAR_PERCENT / 100.0 * abs(p["truth"])


def said(line: dict[str, Any]) -> str:
    """Return a bench's line of progress."""
    named = ", ".join("|".join(entry) for entry in entries_of(line)) or "nothing"
    done = line.get("completed")
    after = (
        f"  then {done['grade']} ({done['cpu_s']:.0f} s), RMS z {rms(errors_of(done)):.2f}, near {is_near(done)}"
        if done
        else ""
    )
    return (
        f"{line['effect']:40} {line['seed']:4d} {line['grade']:6} {line['wall_s']:6.1f} s  "
        f"{'exact' if is_exact(line) else 'WRONG'}  {named}{after}"
    )


def table(lines: Sequence[dict[str, Any]]) -> str:
    """Return the summary: sets named exactly, false names, and what completed mechanisms are like."""
    groups: dict[str, list[dict[str, Any]]] = {}
    for line in lines:
        names = effects_of(line["effect"])
        kind = NOTHING if not names else "two effects" if len(names) > 1 else "one effect"
        kind = kind if all(EFFECTS[name].in_library for name in names) else "no block of the search holds it"
        groups.setdefault(kind, []).append(line)
        if len(names) == 1:
            groups.setdefault(f"  {names[0]}", []).append(line)
    rows = [f"{'benches':34} number  exact        false of all names  without false name  wall s: median  worst"]
    for words, own in sorted(groups.items(), key=lambda pair: (pair[0].startswith(" "), pair[0])):
        exact = sum(map(is_exact, own))
        false = [false_names(names_of(one["effect"], one["size"]), entries_of(one)) for one in own]
        wall = [one["wall_s"] for one in own]
        rows.append(
            f"{words:34} {len(own):6d}  {exact:3d} ({exact / len(own):4.0%})   "
            f"{sum(map(len, false)):5d} of {sum(len(one['missing']) for one in own):4d}     "
            f"{sum(not one for one in false):8d}           {median(wall):10.1f} {max(wall):7.1f}"
        )
    done = [line["completed"] for line in lines if line.get("completed")]
    if done:
        grades = {grade: sum(one["grade"] == grade for one in done) for grade in "ABC"}
        errors = [pair for one in done for pair in errors_of(one)]
        within = sum(map(is_near, done))
        took = [line["cpu_s"] + line["completed"]["cpu_s"] for line in lines if line.get("completed")]
        rows.append(
            f"from the catalogue to the completed fit: {median(took):.0f} s of CPU in the median, "
            f"{max(took):.0f} at most"
        )
        rows.append(
            f"completed: {len(done)}, grades {grades}, within {NEAR_SIGMA:g} sigma and {NEAR_PERCENT:g} % "
            f"(deg) of the truth {within} ({within / len(done):.0%}), RMS z {rms(errors):.2f}, worst "
            f"{max((abs(z) for _, z in errors), default=math.nan):.1f}"
        )
    return "\n".join(rows)


if __name__ == "__main__":
    main()
