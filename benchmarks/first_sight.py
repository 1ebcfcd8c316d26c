"""What `mechid check` and `identify` say of declarations before any search: false alarms, and faults that were made.

    python benchmarks/first_sight.py [--seeds 0:30] [--bench-seeds 0:2] [--campaigns FOLDER ...]    # as declared
    python benchmarks/first_sight.py --faults [--only KIND] [--seeds 0:4]                    # one fault at a time

The first line looks at the campaigns of the recovery benchmark, at the benches with one effect left out from the
catalogue, at both with a model that lacks the housing, a detent or both detents, and at campaigns on disk. Nothing is
fitted.
"""

import argparse
import copy
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

from incomplete.benches import make_bench
from incomplete.effects import EFFECTS
from mechid.campaign import Campaign, CampaignRecord, load_campaign
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.command import Command, RateProfile
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.output_error.declaration import Reading, reinterpret_record
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from mechid.identification.readings.detectors import find_all
from mechid.identification.readings.finding import DeclaredRecords, Finding
from mechid.identification.readings.misreading import confirm_rates, find_misreadings
from mechid.identification.readings.rules import RULES
from mechid.plant.mechanism import Mechanism
from recovery.campaigns import campaign as recovery_campaign
from recovery.mechanisms import FAMILIES, paper_table

RATES = (0.25, 0.5, 0.8, 1.1, 1.5, 2.0, 4.0)


def main() -> None:
    """Look at campaigns as declared, or at those with a fault."""
    arguments = _arguments()
    if arguments.faults:
        faults(range(*arguments.seeds), arguments.only)
    else:
        as_declared(arguments)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=_range, default=(0, 30), metavar="A:B", help="of the recovery benchmark")
    parser.add_argument("--bench-seeds", type=_range, default=(0, 2), metavar="A:B", help="of each effect left out")
    parser.add_argument("--campaigns", type=Path, nargs="*", default=[], metavar="FOLDER", help="on disk")
    parser.add_argument("--faults", action="store_true", help="one fault at a time, in the recovery benchmark's")
    parser.add_argument("--only", default="", metavar="KIND", help='faults whose kind has this, e.g. "rate times"')
    return parser.parse_args()


def _range(text: str) -> tuple[int, int]:
    first, _, last = text.partition(":")
    return int(first), int(last)


def records_of(campaign: Campaign) -> DeclaredRecords:
    """Return the records of a campaign as declared."""
    problem = Problem(SearchSpace(campaign.mechanism), tuple(map(target_of, campaign.estimated)))
    return DeclaredRecords(campaign, problem)


def misreadings_of(campaign: Campaign) -> tuple[Finding, ...]:
    """Return what the spectra of a campaign contradict, as `identify` uses it, on one core."""
    records = records_of(campaign)
    with one_core_algebra():
        return confirm_rates(records, tuple(find_misreadings(records)))


def as_declared(arguments: argparse.Namespace) -> None:
    """Print what is said where all is right; anything is a false alarm."""
    counted, alarms, seconds = Counter(), Counter(), []
    for kind, name, campaign in _right(arguments):
        began = time.process_time()
        with one_core_algebra():
            found = find_all(records_of(campaign))
        seconds.append(time.process_time() - began)
        counted[kind] += 1
        if found:
            alarms[kind] += 1
            print(f"{kind} {name}:", *(finding.line() for finding in found), sep="\n    ", flush=True)
    for kind, count in counted.items():
        print(f"{kind}: {alarms[kind]} alarms in {count} campaigns")
    print(f"CPU seconds: median {sorted(seconds)[len(seconds) // 2]:.2f}, worst {max(seconds):.2f}")


def _right(arguments: argparse.Namespace) -> Iterator[tuple[str, str, Campaign]]:
    """Yield kind, name and campaign."""
    for number, family in FAMILIES.items():
        for seed in range(*arguments.seeds):
            made = recovery_campaign(family.catalogue(), family.truth(seed), seed, "all")
            yield f"recovery, family {number}", str(seed), made
            yield from _lacking(f"{seed}", made) if number == 1 and seed % 5 == 0 else ()
    for effect in EFFECTS:
        for seed in range(*arguments.bench_seeds):
            with tempfile.TemporaryDirectory() as folder:
                made = replace(
                    load_campaign(make_bench(effect, seed, Path(folder)).folder), mechanism=FAMILIES[1].catalogue()
                )
            yield "one effect left out", f"{effect} {seed}", made
            yield from _lacking(f"{effect} {seed}", made) if seed == 0 else ()
    for folder in arguments.campaigns:
        yield "on disk", str(folder), load_campaign(folder)


def _lacking(name: str, campaign: Campaign) -> Iterator[tuple[str, str, Campaign]]:
    for words, mechanism in _poorer():
        yield f"model without {words}", name, replace(campaign, mechanism=mechanism)


def _poorer() -> Iterator[tuple[str, Mechanism]]:
    """Yield catalogues that lack something large."""
    rigid, one, none = (paper_table() for _ in range(3))
    del rigid["housing"]
    del one["stepper"]["detent"][1]
    none["stepper"]["detent"] = [{"period_deg": 1.8, "amplitude": 0.0, "phase_deg": 0.0}]
    for words, table in (("housing", rigid), ("a detent", one), ("detents", none)):
        yield words, mechanism_from_table(copy.deepcopy(table), "catalogue")


def faults(seeds: range, only: str = "") -> None:
    """Print how often each kind of fault is named rightly, wrongly, or not."""
    found: dict[str, Counter[str]] = {}
    for seed in seeds:
        family = FAMILIES[1]
        campaign = recovery_campaign(family.catalogue(), family.truth(seed), seed, "all")
        for kind, names, made, right in _faulty(campaign):
            if only not in kind:
                continue
            findings = misreadings_of(made)
            of = found.setdefault(kind, Counter())
            of[_judged(findings, names, right)] += 1
            of["another record named"] += bool({n for one in findings for n in one.reading} - set(names))
    for kind, counts in found.items():
        print(f"{kind:32} " + ", ".join(f"{count} {words}" for words, count in sorted(counts.items()) if count))


Right = Callable[[Reading], bool]


def _judged(findings: tuple[Finding, ...], names: tuple[str, ...], right: Right | str) -> str:
    if isinstance(right, str):
        return "named" if any(right in finding.line() for finding in findings if not finding.records) else "not named"
    readings = {name: one for finding in findings for name, one in finding.reading.items()}
    if not set(names) & set(readings):
        return "not named"
    used = {name for finding in findings if finding.is_confirmed for name in finding.reading}
    named = "named" if all(name in readings and right(readings[name]) for name in names) else "named otherwise"
    return named + ("" if set(names) <= used else ", and not used")


def _faulty(campaign: Campaign) -> Iterator[tuple[str, tuple[str, ...], Campaign, Right | str]]:
    """Yield kind of fault, records, campaign, and what tells whether it was named rightly."""
    names = [record.name for record in campaign.records]
    for scale in RULES.torque_scales:
        wrong = {name: Reading(scale=1.0 / scale) for name in names}
        yield f"unit of all {scale:g}", (), _taken(campaign, wrong), f"about {1.0 / scale:.3g} times"
        for name in names:
            right = lambda one, k=scale: one.scale == k  # noqa: E731
            yield f"unit of one {scale:g}", (name,), _taken(campaign, {name: wrong[name]}), right
    for name in names:
        true = campaign.record(name).command
        coarse = true.microsteps <= 2
        other = {"stepping": "micro", "microsteps": 16} if coarse else {"stepping": "full", "microsteps": 1}
        kind = f"{'full' if coarse else 'micro'} steps declared as {other['stepping']}"
        yield kind, (name,), _commanded(campaign, name, **other), lambda one, c=coarse: _is_coarse(one) == c
        for factor in RATES:
            rate = RateProfile(true.rate.times_s, tuple(factor * one for one in true.rate.rates))
            right = lambda one, was=true.rate: _near(one, max(was.rates))  # noqa: E731
            yield f"rate times {factor:g}", (name,), _commanded(campaign, name, rate=rate), right
    for one, other in combinations(names, 2):
        swapped = lambda found, pair=(one, other): found.swapped in pair  # noqa: E731
        yield "two swapped", (one, other), _exchanged(campaign, one, other), swapped


def _is_coarse(reading: Reading) -> bool | None:
    return None if reading.microsteps is None else reading.microsteps <= 2


def _near(reading: Reading, rate: float) -> bool:
    found = reading.rate
    return found is not None and abs(max(found.rates) / rate - 1.0) < 0.02


def _taken(campaign: Campaign, taken: dict[str, Reading]) -> Campaign:
    return _with(campaign, {name: reinterpret_record(campaign.record(name), one) for name, one in taken.items()})


def _commanded(campaign: Campaign, name: str, **changes: Any) -> Campaign:
    record = campaign.record(name)
    command: Command = replace(record.command, **changes)
    return _with(campaign, {name: replace(record, command=command)})


def _exchanged(campaign: Campaign, one: str, other: str) -> Campaign:
    a, b = campaign.record(one), campaign.record(other)
    return _with(campaign, {one: replace(a, data=b.data), other: replace(b, data=a.data)})


def _with(campaign: Campaign, records: dict[str, CampaignRecord]) -> Campaign:
    return replace(campaign, records=tuple(records.get(r.name, r) for r in campaign.records))


if __name__ == "__main__":
    main()
