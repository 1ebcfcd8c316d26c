"""The tables: how many true values lie within their stated errors, pooled over fits and by effect; halves; cost."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from statistics import median

import numpy as np

from incomplete.effects import EFFECTS, NOTHING, effects_of

RESAMPLES = 4000
LEAST = 1e-6
"""Distance of a correlation from one that is left to rounding."""
COUNTED = "B"
"""The grade whose intervals are judged on incomplete benches."""
SIGMAS = {"std_error": "stated", "std_error_noise": "noise alone"}
CONTRASTS = ("sums of two", "differences of two")
WITHOUT_NULL = ("stribeck", "backlash", "output_friction")
GROUPS = {
    "smooth, of the library": [n for n, e in EFFECTS.items() if e.in_library and n not in (*WITHOUT_NULL, "clock")],
    "without a null value": list(WITHOUT_NULL),
    "clock": ["clock"],
    "no block holds it": [n for n, e in EFFECTS.items() if not e.in_library],
}
"""Effects by what is asked of a search from the catalogue."""
Pairs = list[tuple[str, float]]
"""Parameters with their errors in standard errors, of one fit."""


def told(line: Mapping) -> str:
    """Return one fit's line of progress."""
    name = f"{line['effect']}/{line['part']} {line['seed']}" if "effect" in line else f"{line['noise']} {line['draw']}"
    errors = errors_of(line)
    worst = max(errors, key=lambda pair: abs(pair[1]), default=("none", math.nan))
    return (
        f"{name:34} {line['cpu_s']:5.1f} s CPU, {line['wall_s']:5.1f} s wall, of it {line['concluding_s']:4.1f} s "
        f"after the search  grade {line['grade']:6} "
        f"RMS z {rms(errors):7.2f}  gate {gate_of(line):6}  worst {worst[0]} {worst[1]:.1f} sigma"
        f"  found {', '.join(one['name'] for one in line.get('missing', ())) or 'nothing'}"
    )


def gate_of(line: Mapping) -> str:
    """Return whether the parts of the records agreed, so that the errors stayed as they were."""
    return {True: "closed", False: "open", None: "none"}[line["agrees"]]


def is_counted(line: Mapping) -> bool:
    """Tell whether the intervals of a fit of an incomplete bench are judged."""
    return line["grade"] == COUNTED


def errors_of(line: Mapping, sigma: str = "std_error") -> Pairs:
    """Return value less truth in standard errors of the parameters that have one."""
    found = line["parameters"].items()
    return [(name, _off(p["value"], p["truth"], p["unit"]) / p[sigma]) for name, p in found if p[sigma]]


def _off(value: float, other: float, unit: str) -> float:
    """Return a difference, of angles on the circle."""
    return (value - other + 180.0) % 360.0 - 180.0 if unit == "deg" else value - other


def contrasts_of(line: Mapping) -> tuple[Pairs, Pairs]:
    """Return the sums and the differences of every two errors in standard errors, in theirs by the correlation.

    Each parameter is in units of its own standard error, so that the correlation alone is on trial.
    """
    z = dict(errors_of(line))
    names, matrix = line["correlation"]["names"], line["correlation"]["matrix"]
    pairs = [(a, b, matrix[i][j]) for i, a in enumerate(names) for j, b in enumerate(names) if i < j]
    sums = [(f"{a} + {b}", (z[a] + z[b]) / math.sqrt(2.0 + 2.0 * rho)) for a, b, rho in pairs if rho > LEAST - 1.0]
    less = [(f"{a} - {b}", (z[a] - z[b]) / math.sqrt(2.0 - 2.0 * rho)) for a, b, rho in pairs if rho < 1.0 - LEAST]
    return sums, less


def between_halves(first: Mapping, second: Mapping, sigma: str = "std_error") -> Pairs:
    """Return the differences of two fits in their common standard errors."""
    out = []
    for name, a in first["parameters"].items():
        b = second["parameters"][name]
        if a[sigma] and b[sigma]:
            out.append((name, _off(a["value"], b["value"], a["unit"]) / math.hypot(a[sigma], b[sigma])))
    return out


def in_interval(line: Mapping) -> list[bool]:
    """Tell of each parameter with a 95 % interval, one-sided ones included, whether it holds the truth."""
    return [
        abs(_off(p["truth"], 0.5 * (p["ci95"][0] + p["ci95"][1]), p["unit"])) <= 0.5 * (p["ci95"][1] - p["ci95"][0])
        for p in line["parameters"].values()
        if p["ci95"]
    ]


def rms(errors: Pairs) -> float:
    """Return the root mean square of errors."""
    return math.sqrt(np.mean([z * z for _, z in errors])) if errors else math.nan


def share_told(clusters: Sequence[Sequence[bool]]) -> str:
    """Return a share with its 95 % interval, fits drawn again whole (bootstrap by cluster, percentiles)."""
    hits = np.array([sum(c) for c in clusters if c])
    sizes = np.array([len(c) for c in clusters if c])
    if not sizes.size:
        return "none"
    drawn = np.random.default_rng(1).integers(sizes.size, size=(RESAMPLES, sizes.size))
    low, high = np.percentile(hits[drawn].sum(axis=1) / sizes[drawn].sum(axis=1), [2.5, 97.5])
    return f"{hits.sum() / sizes.sum():6.1%} ({low:.1%} to {high:.1%})"


def _within(fits: Iterable[Pairs], limit: float) -> list[list[bool]]:
    return [[abs(z) <= limit for _, z in errors] for errors in fits]


def _pooled(words: str, fits: Sequence[Pairs]) -> str:
    """Return the pooled line of some fits."""
    every = [pair for errors in fits for pair in errors]
    if not every:
        return f"{words:34} none"
    worst = max(every, key=lambda pair: abs(pair[1]))
    return (
        f"{words:34} {len(every):5d} of {len(fits):3d} fits  RMS z {rms(every):7.2f}  within 2 "
        f"{share_told(_within(fits, 2.0))}  within 3 {share_told(_within(fits, 3.0))}  worst {worst[0]} {worst[1]:.1f}"
    )


def incomplete_table(lines: Sequence[Mapping]) -> str:
    """Return the summary of benches with an effect left out."""
    whole = [line for line in lines if line["part"] == "whole"]
    counted = [line for line in whole if is_counted(line)]
    rows = [
        "",
        f"{len(whole)} benches with one effect left out: {_counts(line['grade'] for line in whole)}; "
        f"{_opened(whole)}; errors in stated sigmas of the {len(counted)} of grade {COUNTED}, "
        "95 % intervals by fit",
    ]
    rows += [_pooled(words, [errors_of(line, key) for line in counted]) for key, words in SIGMAS.items()]
    rows.append(f"{'true value in the 95 % interval':34} {share_told([in_interval(line) for line in counted])}")
    rows += [_pooled(words, [contrasts_of(line)[k] for line in counted]) for k, words in enumerate(CONTRASTS)]
    rows += ["", *_halves(lines), *_reference(lines), _cost(whole), "", *by_effect(whole)]
    return "\n".join(rows)


def catalogue_table(lines: Sequence[Mapping]) -> str:
    """Return the summary of searches from the catalogue: how many are followed, how well, how soon."""
    rows = [
        "",
        f"{'from the catalogue':24} fits  followed (A or B)  grades            wall s: median  worst  RMS z of A, B",
    ]
    groups = {words: [line for line in lines if line["effect"] in effects] for words, effects in GROUPS.items()}
    groups["several at once"] = [line for line in lines if len(effects_of(line["effect"])) > 1]
    effects = {effect: [line for line in lines if line["effect"] == effect] for effect in (NOTHING, *EFFECTS)}
    for words, own in {**effects, **groups, "all": list(lines)}.items():
        if not own:
            continue
        good = [line for line in own if line["grade"] in ("A", "B")]
        errors = [pair for line in good for pair in errors_of(line)]
        wall = [line["wall_s"] for line in own]
        rows.append(
            f"{words:24} {len(own):4d}  {len(good):3d} ({len(good) / len(own):4.0%})        "
            f"{_counts(line['grade'] for line in own):18} {median(wall):10.1f} {max(wall):6.1f} {rms(errors):12.2f}"
        )
    good = [errors_of(line) for line in lines if line["grade"] in ("A", "B")]
    return "\n".join([*rows, _pooled("grades A and B, stated", good)])


def by_effect(whole: Sequence[Mapping]) -> list[str]:
    """Return a line for each effect."""
    rows = [
        f"{'effect':24} fits  grades                          counted  gate open  RMS z: noise  stated  "
        "within 2  within 3  worst"
    ]
    for effect in dict.fromkeys(line["effect"] for line in whole):
        own = [line for line in whole if line["effect"] == effect]
        counted = [line for line in own if is_counted(line)]
        stated = [pair for line in counted for pair in errors_of(line)]
        noise = [pair for line in counted for pair in errors_of(line, "std_error_noise")]
        worst = max(stated, key=lambda pair: abs(pair[1]), default=("none", math.nan))
        shares = [np.mean([abs(z) <= limit for _, z in stated]) if stated else math.nan for limit in (2.0, 3.0)]
        rows.append(
            f"{effect:24} {len(own):4d}  {_counts(line['grade'] for line in own):32} {len(counted):6d}  "
            f"{sum(line['agrees'] is False for line in own):9d}  {rms(noise):12.2f}  {rms(stated):6.2f}  "
            f"{shares[0]:8.0%}  {shares[1]:8.0%}  {worst[0]} {worst[1]:.1f}"
        )
    return rows


def _halves(lines: Sequence[Mapping]) -> list[str]:
    """Return the lines that hold the halves of each bench against one another."""
    of = {(line["effect"], line["seed"], line["part"]): line for line in lines}
    pairs = [(of[e, s, "first"], of[e, s, "second"]) for e, s, p in of if p == "first" and (e, s, "second") in of]
    kept = [pair for pair in pairs if all(map(is_counted, pair))]
    return [
        _pooled(f"halves, {words}", [between_halves(*pair, key) for pair in kept])
        for key, words in SIGMAS.items()
        if pairs
    ]


def _reference(lines: Sequence[Mapping]) -> list[str]:
    own = [line for line in lines if line["part"] == "reference"]
    head = f"{len(own)} benches without their effect: {_counts(line['grade'] for line in own)}; {_opened(own)}"
    return [head, _pooled("without effect, stated", [errors_of(line) for line in own])] if own else []


def _cost(lines: Sequence[Mapping]) -> str:
    cpu, wall, concluding = ([line[key] for line in lines] for key in ("cpu_s", "wall_s", "concluding_s"))
    if not cpu:
        return "no bench"
    return (
        f"a fit takes {median(cpu):.1f} s of CPU in the median, {max(cpu):.1f} s at most, all {sum(cpu) / 60.0:.1f} "
        f"min; of the wall time {sum(concluding) / sum(wall):.0%} comes after the search"
    )


def complete_table(lines: Sequence[Mapping]) -> str:
    """Return the summary of complete campaigns, by kind of noise and pooled."""
    rows = [""]
    for kind in [*dict.fromkeys(line["noise"] for line in lines), None]:
        own = [line for line in lines if kind in (line["noise"], None)]
        rows.append(
            f"{kind or 'complete, all'}: {len(own)} campaigns: {_counts(line['grade'] for line in own)}; {_opened(own)}"
        )
        rows += [f"  {_pooled(words, [errors_of(line, key) for line in own])}" for key, words in SIGMAS.items()]
        rows.append(f"  {'true value in the 95 % interval':34} {share_told([in_interval(line) for line in own])}")
    return "\n".join([*rows, _cost(lines)])


def _opened(lines: Sequence[Mapping]) -> str:
    return f"gate opened in {sum(line['agrees'] is False for line in lines)} of {len(lines)}"


def _counts(words: Iterable[str]) -> str:
    return ", ".join(f"{count} {word}" for word, count in sorted(Counter(words).items()))
