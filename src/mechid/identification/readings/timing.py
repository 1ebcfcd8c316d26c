"""Detector of wrong times in the records themselves: clocks, triggers, lost rows, sweeps and long rests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from mechid.arrays import FloatArray
from mechid.command.edges import steps_travelled
from mechid.identification.output_error.declaration import Reading
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.readings.finding import DeclaredRecords, Finding, misread_names
from mechid.identification.readings.rules import RULES
from mechid.identification.readings.spectrum import RecordSpectrum
from mechid.identification.readings.trial import compare_readings, declared_readings
from mechid.identification.search.rest import motion_start
from mechid.identification.search.settings import SEARCH
from mechid.records.settings import STEP_RATE

PERIOD_STEPS = 4.0
"""Full steps in one electrical turn, after which the motion at a steady rate repeats itself."""


def find_timing(records: DeclaredRecords, earlier: Sequence[Finding] = ()) -> Iterator[Finding]:
    """Yield clock errors, then sweeps at other rates, late starts and lost rows, then rests that are too long.

    Records with an earlier finding on their rate, stepping or unit are skipped.
    """
    known = misread_names(earlier)
    constant = [t for t in records.readable if len(t.command.rate.rates) == 1 and t.name not in known]
    ratios = {t.name: ratio for t in constant if (ratio := rate_ratio(records.spectra[t.name]))}
    yield from _clock_errors(ratios, constant)
    found: list[Finding | None] = [
        find_sweep_rate(t) for t in records.readable if len(t.command.rate.rates) > 1 and t.name not in known
    ]
    for target in constant:
        found.append(_find_late_start(records.problem, target))
        # At another rate every period shifts, which would look like lost rows.
        found += [find_lost_rows(target)] if target.name not in ratios else []
    found += map(find_long_rest, records.problem.targets)
    yield from (one for one in found if one is not None)


def rate_ratio(spectrum: RecordSpectrum) -> float | None:
    """Return the ratio of the rate shown by a record's lines to the declared one, where it is off by a few per cent."""
    own, declared = spectrum.suggested_rate, spectrum.fastest_rate
    if own is None or not own.is_constant or not declared:
        return None
    ratio = min((own.repetition_hz * whole / declared for whole in STEP_RATE.readable), key=lambda one: abs(one - 1.0))
    least = max(RULES.least_clock_error, RULES.clock_sigmas * own.sigma / own.rate)
    return ratio if least < abs(ratio - 1.0) < RULES.most_clock_error else None


def _clock_errors(ratios: Mapping[str, float], constant: Sequence[Target]) -> Iterator[Finding]:
    """Yield findings on records that run at another rate; an error common to all records is attributed to one clock."""
    if len(ratios) > 1 and len(ratios) == len(constant) and float(np.ptp(list(ratios.values()))) < RULES.same_clock:
        ratio = float(np.median(list(ratios.values())))
        yield Finding(
            (),
            "clock",
            f"their lines are at {ratio:.5g} times the declared rates: the recorder's clock, the sample rate or the "
            f"time stamps seem {_format_percent(1.0 / ratio)} % off, or all rates {_format_percent(ratio)} %",
        )
        return
    for target in constant:
        if target.name in ratios:
            ratio, declared = ratios[target.name], target.command.rate.rates[0]
            yield Finding(
                (target.name,),
                "clock",
                f"its lines are those of {ratio * declared:.5g} full steps/s (declared {declared:.5g}): the rate is "
                f"{_format_percent(ratio)} % off, or the record's sample rate (its clock) "
                f"{_format_percent(1.0 / ratio)} %",
            )


def _format_percent(ratio: float) -> str:
    return f"{100.0 * (ratio - 1.0):+.2g}"


def _find_late_start(problem: Problem, target: Target) -> Finding | None:
    """Report a record that rests during the first two commanded full steps, where it does not fit as declared.

    Two steps move any load that is not held. The remedy is proposed where a later command makes the first steps fit.
    Motion that begins too early is not reported: a rotor that starts outside a detent's rest moves before any step.
    """
    if target.command.microsteps > RULES.coarse_microsteps or not target.command.rate.rates[0]:
        return None
    base, step_s = target.base, 1.0 / abs(target.command.rate.rates[0])
    moves = _first_motion(target)
    commanded = moves - target.time_offset.value if moves is not None else 0.0
    if moves is None or commanded < 2.0 * step_s or base.start_s > target.time_offset.value:
        return None
    value = commanded - step_s  # so much too early the command seems to begin
    least, most = value - step_s, value + step_s
    reading = {target.name: Reading(time_offset_s=(value, least, most))}
    declared, moved = compare_readings(problem, [declared_readings([target.name]), reading])
    if declared.explains:
        return None
    remedy = (
        f"is the recorder's trigger some {value:.2g} s early? write "
        f"time_offset_s = {{ value = {value:.3g}, min = {least:.3g}, max = {most:.3g} }}"
        if moved.is_better_than(declared)
        else "a later command does not make it fit: check how its numbers and times were read (mechid look)"
    )
    steps = int(commanded / step_s)
    text = f"it rests until {moves:.4g} s, although its command has made {steps} full steps by then"
    return Finding((target.name,), "late start", text, remedy)


def _first_motion(target: Target) -> float | None:
    """Return the record time at which a torque leaves its rest; None if it begins in motion or never moves."""
    rate = target.base.sample_rate_hz
    width = max(round(RULES.rest_s * rate), 1)
    if width >= target.samples:  # so short a record shows no rest
        return None
    y = target.leading.measured[: round(min(target.base.duration_s, 100.0 * RULES.rest_s + 20.0) * rate)]
    smooth = np.convolve(y, np.full(width, 1.0 / width), "valid")
    swing = 0.5 * float(np.ptp(np.quantile(smooth, RULES.swing_quantiles)))
    least = max(RULES.moves_sigmas * target.leading.sigma / np.sqrt(width), RULES.moves_share * swing)
    moving = np.flatnonzero(np.abs(smooth - float(np.mean(y[:width]))) > least)
    return target.base.start_s + float(moving[0]) / rate if moving.size and moving[0] > 0 else None


def find_long_rest(target: Target) -> Finding | None:
    """Report a record that rests for longer than the search for a start looks ahead."""
    base, moves = target.base, motion_start(target)
    rest_s = (moves - target.burn_in) / base.sample_rate_hz
    if rest_s <= SEARCH.longest_rest_s or moves >= target.samples:
        return None
    first_s, last_s = base.start_s + moves / base.sample_rate_hz, base.start_s + base.duration_s
    return Finding(
        (target.name,),
        "long rest",
        f"it rests for {rest_s:.3g} s; the search judges starts within the first {SEARCH.longest_rest_s:g} s, where "
        "they cannot differ",
        f"write window_s = [{first_s - RULES.kept_rest_s:.6g}, {last_s:.6g}] for it, which moves no time",
    )


def find_lost_rows(target: Target) -> Finding | None:
    """Report a steady motion whose phase jumps at some period: lost rows, or a jump of the clock.

    The two periods next to the jump have to show it as well: a motion that settles approaches its phase gradually.
    """
    rate = abs(target.command.rate.rates[0])
    if not rate or target.begins_in_motion:
        return None
    fs, period_s = target.base.sample_rate_hz, PERIOD_STEPS / rate
    spread = max(RULES.steady_share * RULES.least_jump_steps * fs / rate, 1.0)
    shifts, alike = _period_shifts(target.leading.measured[: RULES.most_samples], period_s * fs)
    fewest = RULES.least_periods
    # The first period contains the beginning of the motion.
    for k in range(fewest + 1, shifts.size - fewest):
        sides = shifts[1:k], shifts[k + 1 :]
        steady = all(float(np.ptp(side)) <= spread for side in sides)
        jump = float(np.median(sides[0]) - np.median(sides[1]))
        sudden = min(abs(jump), abs(float(shifts[k - 1] - shifts[k + 1])))
        if not steady or min(*alike[1:k], *alike[k + 1 :]) < RULES.same_period or sudden < RULES.least_jump_samples:
            continue
        steps = jump / fs * rate
        whole = abs(round(steps))
        if abs(steps) >= RULES.least_jump_steps and abs(abs(steps) - whole) >= RULES.lost_step_margin * min(whole, 1):
            return _jump_finding(target, target.base.start_s + k * period_s, jump)
    return None


def _jump_finding(target: Target, at_s: float, samples: float) -> Finding:
    rows, way = ("lost", "ahead") if samples > 0.0 else ("too many, or lost elsewhere", "behind")
    return Finding(
        (target.name,),
        "lost rows",
        f"its motion goes on {abs(samples) / target.base.sample_rate_hz:.2g} s {way} from about {at_s:.2g} s on: some "
        f"{abs(samples):.0f} rows are {rows}, or its clock jumps there",
        "use one side of it (window_s), or a file with time stamps",
    )


def _period_shifts(y: FloatArray, period: float) -> tuple[FloatArray, FloatArray]:
    """Return the shift of each period against the last one, samples, (k,), and the correlation at that shift, (k,)."""
    if not RULES.points_a_step <= period < y.size:
        return np.zeros(0), np.zeros(0)
    count, size = int(y.size / period), int(period)
    if count < 2 * RULES.least_periods + 2:
        return np.zeros(0), np.zeros(0)
    places = np.arange(size) + period * np.arange(count)[:, np.newaxis]
    blocks = np.interp(places, np.arange(y.size), y)
    blocks -= blocks.mean(axis=1, keepdims=True)
    # Circular cross-correlation of all periods with the last one, by one transform each.
    spectra = np.fft.rfft(blocks)
    product = np.fft.irfft(spectra * np.conj(spectra[-1]), size)
    at = np.argmax(product, axis=1)
    norms = np.linalg.norm(blocks, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        alike = product[np.arange(count), at] / (norms * norms[-1])
    return np.where(at > size // 2, at - size, at).astype(np.float64), np.nan_to_num(alike)


def find_sweep_rate(target: Target) -> Finding | None:
    """Report a sweep whose lines are at another rate; with the right rate they lag by one or two turns."""
    rates = np.array(target.command.rate.rates)
    if np.any(rates < 0.0) and np.any(rates > 0.0):
        return None
    steps, y = _resample_over_steps(target)
    unknown = _trigger_range_steps(target)
    clear = [found for order in RULES.sweep_orders if (found := _clear_line(steps, y, order, unknown))]
    if not clear:
        return None
    ratio = max(clear)[1]
    off, clock = 100.0 * (ratio - 1.0), 100.0 * (1.0 / ratio - 1.0)
    return Finding(
        (target.name,),
        "sweep rate",
        f"its lines are those of some {ratio:.3g} times the declared rates: the rates are about {off:+.1g} % off, or "
        f"the record's sample rate (its clock) {clock:+.1g} %",
    )


def _resample_over_steps(target: Target) -> tuple[float, FloatArray]:
    """Resample the torque over equal distances of travel at a constant amplitude; also return the full steps read."""
    base, points = target.base, RULES.points_a_step
    y = target.leading.measured[: RULES.most_samples]
    time = base.start_s + np.arange(y.size) / base.sample_rate_hz - target.time_offset.value
    travelled = np.abs(steps_travelled(target.command.rate, time))
    last = min(float(travelled[-1]), RULES.sweep_steps)
    if last < PERIOD_STEPS:
        return 0.0, np.zeros(0)
    # Smoothed over a quarter of a travel sample at the fastest rate: interpolation would alias faster content.
    width = max(int(base.sample_rate_hz / (4.0 * points * max(map(abs, target.command.rate.rates)))), 1)
    smooth = np.convolve(y - np.mean(y), np.full(width, 1.0 / width), "same")
    own = np.interp(np.arange(0.0, last, 1.0 / points), travelled, smooth)
    around = np.full(max(int(PERIOD_STEPS * PERIOD_STEPS * points), 1), PERIOD_STEPS**-2.0 / points)
    level = np.sqrt(np.convolve(own**2, around, "same")) if own.size >= around.size else np.zeros(own.size)
    return last, np.divide(own, level, out=np.zeros_like(own), where=level > 0.0)


def _trigger_range_steps(target: Target) -> tuple[float, float]:
    """Return the full steps by which a free trigger may put a record behind its command, and ahead of it."""
    delay, fastest = target.time_offset, float(np.max(np.abs(target.command.rate.rates)))
    if not delay.is_free:
        return 0.0, 0.0
    return fastest * (delay.max - delay.value), fastest * (delay.value - delay.min)


def _clear_line(
    steps: float, y: FloatArray, order: float, unknown: tuple[float, float] = (0.0, 0.0)
) -> tuple[float, float] | None:
    """Return the clearness of a line at a wrong rate, and its ratio to the declared rate; None for a right rate."""
    turns, lag, lead = order * steps, *(order * one for one in unknown)
    if turns < (RULES.sweep_lag_turns + RULES.sweep_lead_turns) / RULES.sweep_reach:
        return None
    # Zero padding by four: a line between two bins keeps its height.
    power = np.abs(np.fft.rfft(y, 4 * y.size)) ** 2
    ratio = np.fft.rfftfreq(4 * y.size, 1.0 / RULES.points_a_step) / order
    near = np.abs(ratio - 1.0) < RULES.sweep_reach
    least, most = 1.0 - (RULES.sweep_lag_turns + lag) / turns, 1.0 + (RULES.sweep_lead_turns + lead) / turns
    right = near & (ratio > least) & (ratio < most)
    at = int(np.argmax(np.where(near, power, 0.0)))
    clearness = float(power[at] / np.median(power[near]))
    if right[at] or clearness < RULES.sweep_clear or power[at] < RULES.sweep_nearer * float(power[right].max()):
        return None
    return clearness, float(ratio[at]) + 1.0 / turns
