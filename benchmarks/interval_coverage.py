"""Whether the 95 % intervals hold the truth in 95 of 100 campaigns: white noise and two coloured ones.

Each draw is a campaign of its own: the same mechanism and test runs, new noise, offsets and drifts. The first one
with white noise is identified from the catalogue; all others start from its estimate and go through the plan's
joint fits, release of the noise and conclusion. One line of JSON is appended for each; what is in the file already is
not repeated, so a run may be stopped, taken up again, and done in pieces. A changed method wants a new file.

    python benchmarks/interval_coverage.py --noise white|ar888|ar46 --draws 0:400 [--workers 2] [--out FILE]
        [--scheduler ADDRESS]
"""

import argparse
import json
import math
import statistics
import time
from collections import Counter
from functools import partial
from importlib import import_module
from pathlib import Path

import numpy as np
from scipy.signal import lfilter
from scipy.stats import binomtest, norm, t

from mechid.campaign import Campaign, catalogue_mechanism
from mechid.campaign.bench import TRUTH
from mechid.identification.computation.parallel import map_tasks
from mechid.identification.computation.workforce import working_on_scheduler
from mechid.identification.identify import identify
from mechid.identification.result.fit import Fit
from recovery.campaigns import DRIFT_NM, NOISE_NM, OFFSET_NM, RATE_HZ, record_of, runs_of, torque_of

OUT = Path("build/coverage.jsonl")
RECORDS = ("full_res", "full_half", "micro_res", "micro_2res")
POLES = {"white": None, "ar888": (0.9, 888.0), "ar46": (0.99, 46.0)}
"""Radius and frequency in Hz of the noise's pair of poles; its standard deviation is the same in all."""
FIRST = ("white", 0)
"""The campaign that is identified from the catalogue."""
WARM_UP = 20_000
LEVEL = 0.95


def main() -> None:
    """Fit what is not in the file yet, and print the coverage of what was asked for."""
    arguments = _arguments()
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    done = {(line["noise"], line["draw"]): line for line in _lines(arguments.out)}
    mechanism = catalogue_mechanism().with_values(TRUTH)
    clean = {name: torque_of(mechanism, runs_of(mechanism)[name]) for name in RECORDS}
    keys = list(dict.fromkeys([FIRST, *((arguments.noise, draw) for draw in range(*arguments.draws))]))
    own = import_module("interval_coverage")  # by the name by which workers find it, too
    with working_on_scheduler(arguments.scheduler):
        for some in ([FIRST], keys):
            left = [key for key in some if key not in done]
            near = done[FIRST]["estimate"] if FIRST in done else None
            work = partial(own.fitted, clean, mechanism, near, arguments.workers)
            map_tasks(work, left, 1, partial(_noted, arguments.out, done))
    asked = [done[arguments.noise, draw] for draw in range(*arguments.draws)]
    print(table(arguments.noise, asked))


def fitted(clean, mechanism, near, workers: int | None, key: tuple[str, int]) -> dict:
    """Return the line of a draw, by noise and number."""
    began = time.perf_counter()
    fit = identify(drawn(clean, mechanism, *key), workers=workers, near=near)
    return {"noise": key[0], "draw": key[1], "seconds": time.perf_counter() - began, **line_of(fit)}


def _noted(path: Path, done: dict, some) -> None:
    for _, line, _ in some:
        done[line["noise"], line["draw"]] = line
        with path.open("a") as file:
            file.write(json.dumps(line) + "\n")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--noise", choices=sorted(POLES), default="white")
    parser.add_argument("--draws", type=_range, default=(0, 400), metavar="A:B", help="from A up to, not with, B")
    parser.add_argument("--workers", type=int, default=None, help="threads of each fit")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="Dask scheduler; workers need this folder in PYTHONPATH")
    parser.add_argument("--out", type=Path, default=OUT, help=f"file to be continued, {OUT} by default")
    return parser.parse_args()


def _range(text: str) -> tuple[int, int]:
    first, _, last = text.partition(":")
    return int(first), int(last)


def _lines(path: Path):
    """Yield what the file holds; a last line that a killed run left unfinished is no line."""
    for text in path.read_text().splitlines() if path.exists() else []:
        try:
            yield json.loads(text)
        except json.JSONDecodeError:
            continue


def drawn(clean, mechanism, noise: str, draw: int) -> Campaign:
    """Return the campaign of a draw: the test runs of the mechanism with noise, to be fitted from the catalogue."""
    rng = np.random.default_rng((sorted(POLES).index(noise), draw))
    records = []
    for name, torque in clean.items():
        line = OFFSET_NM * rng.standard_normal() + DRIFT_NM * rng.standard_normal() * np.linspace(0.0, 1.0, torque.size)
        samples = torque + line + noise_series(rng, noise, torque.size)
        records.append(record_of(name, samples, runs_of(mechanism)[name].command))
    return Campaign(
        path=Path("campaign.toml"),
        mechanism_path=Path("mechanism.toml"),
        mechanism=catalogue_mechanism(),
        records=tuple(records),
    )


def noise_series(rng: np.random.Generator, noise: str, samples: int) -> np.ndarray:
    """Return noise of standard deviation `NOISE_NM`: white, or AR(2) with a pair of complex poles."""
    if POLES[noise] is None:
        return NOISE_NM * rng.standard_normal(samples)
    radius, frequency_hz = POLES[noise]
    a = [1.0, -2.0 * radius * math.cos(2.0 * math.pi * frequency_hz / RATE_HZ), radius**2]
    series = lfilter([1.0], a, rng.standard_normal(samples + WARM_UP))[WARM_UP:]
    return NOISE_NM / math.sqrt(_variance(a)) * series


def _variance(a: list[float]) -> float:
    """Return the variance of an AR(2) process driven by white noise of unit variance."""
    _, a1, a2 = a
    return (1.0 + a2) / ((1.0 - a2) * ((1.0 + a2) ** 2 - a1**2))


def line_of(fit: Fit) -> dict:
    """Return what of a fit is kept."""
    own = {name: fit.parameters[name] for name in TRUTH}
    return {
        "outcome": fit.outcome.code,
        "estimate": {name: p.value for name, p in own.items()},
        "std_error": {name: p.std_error for name, p in own.items()},
        "std_error_white": {name: p.std_error_white for name, p in own.items()},
        "local_only": sorted(name for name, p in own.items() if p.local_only),
        "status": {name: p.status for name, p in own.items() if p.status != "free"},
        "prefilter": {name: r.prefilter_order for name, r in fit.records.items()},
        "warnings": list(fit.warnings),
    }


def error_in_sigmas(line: dict, name: str) -> float | None:
    """Return the estimate less the truth in standard errors; None where there is none."""
    sigma = line["std_error"][name]
    off = line["estimate"][name] - TRUTH[name]
    if name.endswith("_deg"):
        off = (off + 180.0) % 360.0 - 180.0
    return off / sigma if sigma else None


def table(noise: str, lines: list[dict]) -> str:
    """Return coverage by parameter and pooled; intervals marked `local only`, and none at all, are tallied apart."""
    confidence = 1.0 - 0.05 / len(TRUTH)
    limit = norm.ppf(0.5 + 0.5 * LEVEL)
    rows = [
        f"{noise}: {len(lines)} campaigns; outcomes {_counted(line['outcome'] for line in lines)}; "
        f"median {statistics.median(line['seconds'] for line in lines):.2f} s a campaign",
        "",
        f"{'parameter':28} holds  of   coverage  Clopper-Pearson {confidence:.2%}  scatter/sigma  local only  none",
    ]
    shares, excluded = {}, []
    for name in TRUTH:
        errors = {i: error_in_sigmas(line, name) for i, line in enumerate(lines)}
        apart = [i for i, line in enumerate(lines) if name in line["local_only"]]
        counted = {i: e for i, e in errors.items() if e is not None and i not in apart}
        if not counted:
            rows.append(f"{name:28} no interval that counts; local only {len(apart)}")
            continue
        for i, e in counted.items():
            shares.setdefault(i, []).append(abs(e) <= limit)
        held = sum(abs(e) <= limit for e in counted.values())
        interval = binomtest(held, len(counted)).proportion_ci(confidence, method="exact")
        mark = "" if interval.low <= LEVEL <= interval.high else "  EXCLUDES 95 %"
        excluded += [name] if mark else []
        apart_held = sum(abs(errors[i]) <= limit for i in apart if errors[i] is not None)
        rows.append(
            f"{name:28} {held:5d} {len(counted):4d}   {held / len(counted):7.1%}  {interval.low:9.1%} to "
            f"{interval.high:6.1%}       {math.sqrt(statistics.fmean(e * e for e in counted.values())):6.2f}"
            f"        {apart_held:4d} of {len(apart):<4d} {sum(e is None for e in errors.values()):3d}{mark}"
        )
    return "\n".join([*rows, "", pooled(list(shares.values())), f"excluding 95 %: {', '.join(excluded) or 'none'}"])


def _counted(codes) -> str:
    return ", ".join(f"{count} {code}" for code, count in Counter(codes).items())


def pooled(shares: list[list[bool]]) -> str:
    """Return the pooled coverage with an interval that takes each campaign, not each parameter, as one observation."""
    hits, sizes = np.array([sum(s) for s in shares]), np.array([len(s) for s in shares])
    ratio = hits.sum() / sizes.sum()
    n = len(shares)
    error = math.sqrt(n / (n - 1) * np.sum((hits - ratio * sizes) ** 2)) / sizes.sum() if n > 1 else math.inf
    half = t.ppf(0.975, n - 1) * error if n > 1 else math.inf
    return f"pooled {ratio:.2%}; 95 % interval clustered by campaign {ratio - half:.2%} to {ratio + half:.2%}"


if __name__ == "__main__":
    main()
