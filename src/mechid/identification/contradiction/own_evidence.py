"""Evidence of the records themselves: clocks that are off, motion at the wrong time, mains hum."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence

import numpy as np

from mechid.identification.contradiction.own_timing import late_start, lost_rows, rests_too_long, swept_rate
from mechid.identification.contradiction.record_sight import RecordSight, is_looked_at, sight_of
from mechid.identification.contradiction.trial import declared, trials
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.records.settings import STEP_RATE
from mechid.signal.lines import Prominence, prominence
from mechid.signal.mains import LOW_MULTIPLES, MainsLine, mains_lines

MOST_OFF, LEAST_OFF, SURE = 0.05, 2e-3, 8.0
"""Relative distances of a rate from the one declared that are looked for, and standard errors that make one sure.
Without a false alarm in 60 campaigns of the recovery benchmark (benchmarks/first_sight.py); not varied."""
ALIKE = 5e-4
"""Relative distances that differ by no more have one cause, the recorder's clock; a choice, not measured."""
LEAST_HUM = 0.5
"""Of a channel's noise level: smaller lines of hum change little, and are left to `identify`."""
SKIRT_BINS, NARROW = range(3, 7), 0.5
"""Bins beside a line of hum, and of its height what they stay below: benches' hum gave 0.23, resonances 0.8 to 1.1."""
ORDER_PARTS, NEAR_BINS = 4, 1.0
"""A line of hum this near to a quarter order of the step rate, in bins, may be one; a choice, not measured."""


def own_evidence(problem: Problem, said: Container[str]) -> list[str]:
    """Return lines for records whose clock seems off, that begin late, that lack rows, or rest for long.

    Parameters
    ----------
    problem : Problem
        All records as declared; looked at are those of which the torque leads, under a command.
    said : container of record names
        Those whose rate or stepping is plainly otherwise already.
    """
    seen = [t for t in problem.targets if is_looked_at(t)]
    constant = [t for t in seen if len(t.command.rate.rates) == 1 and t.name not in said]
    off = {t.name: ratio for t in constant if (ratio := rate_ratio(sight_of(t)))}
    swept = [swept_rate(t) for t in seen if len(t.command.rate.rates) > 1 and t.name not in said]
    timed = [line for t in constant for line in (_late(problem, t), lost_rows(t) if t.name not in off else "")]
    resting = map(rests_too_long, problem.targets)
    return [*_off_lines(off, constant), *filter(None, (*swept, *timed, *resting))]


def _late(problem: Problem, target: Target) -> str:
    """Say that a record begins to move late where its first steps do not fit as declared; the remedy where it helps."""
    late = late_start(target)
    if late is None:
        return ""
    as_declared, moved = trials(problem, [declared([target.name]), {target.name: late.reading}])
    return "" if as_declared.explains else late.line(helps=moved.is_better_than(as_declared))


def rate_ratio(sight: RecordSight) -> float | None:
    """Return the rate of a record's own lines over the one declared; None where it is the declared or another one."""
    own, declared = sight.own, sight.fastest
    if own is None or not own.is_constant or not declared:
        return None
    ratio = min((own.repetition_hz * whole / declared for whole in STEP_RATE.readable), key=lambda one: abs(one - 1.0))
    least = max(LEAST_OFF, SURE * own.sigma / own.rate)
    return ratio if least < abs(ratio - 1.0) < MOST_OFF else None


def _off_lines(off: Mapping[str, float], constant: Sequence[Target]) -> Iterator[str]:
    """Say which records run at another rate: all of them alike are one clock."""
    ratios = np.array(list(off.values()))
    if len(off) > 1 and len(off) == len(constant) and float(np.ptp(ratios)) < ALIKE:
        ratio = float(np.median(ratios))
        yield (
            f"all records: their lines are at {ratio:.5g} times the rates declared: the recorder's clock, the sample "
            f"rate or the time stamps seem {_percent(1.0 / ratio)} %, or all rates {_percent(ratio)} % off"
        )
        return
    for target in constant:
        if target.name in off:
            ratio = off[target.name]
            rate = ratio * target.command.rate.rates[0]
            yield (
                f"record {target.name}: its lines are those of {rate:.5g} full steps/s (declared "
                f"{target.command.rate.rates[0]:.5g}): the rate is {_percent(ratio)} % off, or the record's sample "
                f"rate (its clock) {_percent(1.0 / ratio)} %"
            )


def _percent(ratio: float) -> str:
    return f"{100.0 * (ratio - 1.0):+.2g}"


def hum_lines(targets: Sequence[Target]) -> list[str]:
    """Say which records have lines of the mains that are none of the step rate; `identify` removes them by itself."""
    found = {target.name: line for target in filter(is_looked_at, targets) if (line := _strongest_hum(target))}
    if not found:
        return []
    name, line = max(found.items(), key=lambda item: item[1].line.amplitude)
    return [
        f"record{'s' * (len(found) > 1)} {', '.join(found)}: a line at {line.line.frequency_hz:.5g} Hz, of "
        f"{line.line.amplitude:.2g} N m in {name}, is mains hum by its frequency; write mains = {line.mains_hz:g} "
        "in [identify] to have it taken out of all records"
    ]


def _strongest_hum(target: Target) -> MainsLine | None:
    """Return the strongest line of a grid where it is a low multiple: of the high ones a short record is near many."""
    found = prominence(target.leading.measured, target.base.sample_rate_hz)
    rates = set(map(abs, target.command.rate.rates))
    orders = [rate / ORDER_PARTS for rate in rates if rate and len(rates) == 1]
    loud = [one for one in mains_lines(found) if one.line.amplitude > LEAST_HUM * target.leading.sigma]
    own = [one for one in loud if not any(_is_order(one, o, found.bin_hz) for o in orders)]
    if len(rates) > 1:
        own = [one for one in own if _is_narrow(one, found)]
    strongest = max(own, key=lambda one: one.line.amplitude, default=None)
    return strongest if strongest and strongest.multiple <= LOW_MULTIPLES else None


def _is_narrow(one: MainsLine, found: Prominence) -> bool:
    """Tell hum from what a rate does that passes a resonance: that is as high some bins beside."""
    at = round(one.line.frequency_hz / found.bin_hz)
    beside = (found.amplitude[at + sign * bins] for sign in (-1, 1) for bins in SKIRT_BINS)
    return bool(max(beside, default=0.0) < NARROW * found.amplitude[at])


def _is_order(one: MainsLine, order_hz: float, bin_hz: float) -> bool:
    hz = one.line.frequency_hz
    return abs(hz - round(hz / order_hz) * order_hz) < NEAR_BINS * bin_hz
