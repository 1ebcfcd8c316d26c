"""Detector of records whose spectra contradict their declaration; each remedy is tested before it is proposed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from mechid.identification.output_error.declaration import Reading
from mechid.identification.readings.finding import (
    SAME_UNIT,
    TORQUE_UNITS,
    UNEXPLAINED,
    Confidence,
    DeclaredRecords,
    Finding,
    reading_words,
    unit_remedy,
)
from mechid.identification.readings.rules import RULES
from mechid.identification.readings.spectrum import own_rates
from mechid.identification.readings.suspicion import Suspicions, suspect
from mechid.identification.readings.trial import Trial, compare_readings, declared_readings, strongest_records
from mechid.identification.search.settings import SEARCH
from mechid.units import to_si_factor

Readings = Mapping[str, Reading]
RATE = "rate"
"""Cause of a finding about another rate of a record."""


def find_misreadings(records: DeclaredRecords, earlier: Sequence[Finding] = ()) -> Iterator[Finding]:
    """Yield findings on all records, then on single ones; records that no reading explains come last."""
    suspicions = suspect(records.problem, records.spectra, records.seed)
    if suspicions.common_scale != 1.0:
        yield from _common_unit(records, suspicions.common_scale)
    if suspicions.failing:
        yield _unstable_finding(suspicions.failing)
    if suspicions.cut_off_hz:
        yield _low_pass_finding(suspicions.cut_off_hz)
    found = [
        one for names, readings in _suspected_readings(records, suspicions) for one in _judge(records, names, readings)
    ]
    explained = [one for one in found if one.cause != UNEXPLAINED]
    yield from (_mark_ambiguous(one, suspicions) for one in explained)
    yield from sorted((one for one in found if one.cause == UNEXPLAINED), key=lambda one: one.records)


def _suspected_readings(
    records: DeclaredRecords, suspicions: Suspicions
) -> Iterator[tuple[tuple[str, ...], list[Readings]]]:
    """Yield the records of each suspicion with its candidate readings, the suggested one first."""
    for name, reading in suspicions.readings.items():
        if reading.swapped is not None:
            pair = (name, reading.swapped)
            # Both records of a swap carry the suspicion: the pair is yielded once.
            if name < reading.swapped:
                yield pair, [{one: suspicions.readings[one] for one in pair}]
        elif reading.scale != 1.0:
            same_way = [k for k in RULES.torque_scales if (k > 1.0) == (reading.scale > 1.0)]
            scales = _usual_scales([reading.scale, *same_way], records.unit_factor(name))
            yield (name,), [{name: Reading(scale=scale)} for scale in scales]
        elif reading.rate is not None:
            rates = own_rates(records.spectra[name])
            yield (name,), [{name: replace(reading, rate=rate)} for rate in rates]
        else:
            yield (name,), [{name: reading}]


def _usual_scales(suggested: Sequence[float], factor: float) -> list[float]:
    """Return the suggested scales and the scales of usual units near them, without duplicates."""
    units = [to_si_factor(unit, "torque") / factor for unit in TORQUE_UNITS]
    most = RULES.unit_factor
    near = [u for u in units if any(1.0 / most < u / scale < most for scale in suggested) and abs(u - 1.0) > SAME_UNIT]
    found: list[float] = []
    for scale in (*suggested, *near):
        if all(abs(scale / other - 1.0) > SAME_UNIT for other in found):
            found.append(scale)
    return found


def _judge(records: DeclaredRecords, names: tuple[str, ...], readings: Sequence[Readings]) -> Iterator[Finding]:
    """Yield the finding on a suspicion: the readings with which the records fit, or that there is none.

    Yields nothing where the records fit as declared.
    """
    declared, *tried = compare_readings(records.problem, [declared_readings(names), *readings])
    if declared.explains:
        return
    helping = _helping_trials(declared, tried)
    if not helping:
        yield from map(_unexplained_finding, names)
        return
    best, *rivals = (readings[k] for k in helping)
    if len(names) == 2:
        yield Finding(
            names,
            "swapped",
            "they seem to be swapped: the spectrum of each is that of the other's command",
            "if that is right, exchange their files in the campaign file",
            Confidence.AMBIGUOUS if rivals else Confidence.CONFIRMED,
            best,
        )
    else:
        yield _misreading_finding(records, names[0], best, rivals)


def _misreading_finding(records: DeclaredRecords, name: str, best: Readings, rivals: Sequence[Readings]) -> Finding:
    record, reading = records.campaign.record(name), best[name]
    words, remedy = reading_words(record, reading)
    others = "".join(f" or {reading_words(record, rival[name])[0]}" for rival in rivals)
    return Finding(
        (name,),
        "unit" if reading.scale != 1.0 else RATE if reading.rate is not None else "stepping",
        f"its spectrum is not that of its declaration, but that of a record with {words}{others}",
        f"if that is right, write {remedy} for it in the campaign file",
        Confidence.AMBIGUOUS if rivals else Confidence.CONFIRMED,
        best,
    )


def confirm_rates(records: DeclaredRecords, findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Confirm another rate only where missing terms of the mechanism do not explain it.

    A missing term may look like another rate: offsets of the phases repeat after four steps, as do steps at half the
    rate. So the first moments of the record and of the strongest others are compared with all terms free, as declared
    and at the other rate.
    """
    return tuple(_confirm_rate(records, one) for one in findings)


def _confirm_rate(records: DeclaredRecords, finding: Finding) -> Finding:
    if finding.cause != RATE or not finding.is_confirmed:
        return finding
    others = [t for t in records.readable if t.name not in finding.records]
    names = (*finding.records, *(t.name for t in strongest_records(others)[: RULES.trial_records - 1]))
    readings = [declared_readings(names), {**declared_readings(names), **finding.reading}]
    declared, other = compare_readings(records.problem, readings, with_terms=True)
    if not declared.explains and other.is_better_than(declared):
        return finding
    why = "; not read so: with all terms free that the mechanism file lacks, it does not fit clearly better"
    return replace(finding, text=finding.text + why, confidence=Confidence.AMBIGUOUS)


def _mark_ambiguous(finding: Finding, suspicions: Suspicions) -> Finding:
    """Mark a finding as ambiguous where the lines of its swapped records fit the declared rates as well."""
    return replace(finding, confidence=Confidence.AMBIGUOUS) if suspicions.doubtful & set(finding.records) else finding


def _helping_trials(declared: Trial, tried: Sequence[Trial]) -> list[int]:
    """Return the indices of the trials that help, the best first, without those clearly worse than the best."""
    order = sorted((k for k, one in enumerate(tried) if one.is_better_than(declared)), key=lambda k: tried[k].cost)
    most = max(RULES.trial_gain * tried[order[0]].cost, SEARCH.good_cost) if order else 0.0
    return [k for k in order if tried[k].cost <= most]


def _common_unit(records: DeclaredRecords, suspected: float) -> Iterator[Finding]:
    """Yield a finding on the unit of all records, tested on the strongest; nothing where they fit as declared."""
    names = [t.name for t in strongest_records(records.readable)]
    scales = _usual_scales([suspected], records.unit_factor(names[0]))
    readings = [dict.fromkeys(names, Reading(scale=k)) for k in scales]
    declared, *tried = compare_readings(records.problem, [declared_readings(names), *readings])
    if declared.explains:
        return
    found = [scales[k] for k in _helping_trials(declared, tried)]
    if not found:
        yield _level_finding("far larger" if suspected < 1.0 else "far smaller")
        return
    record = next(r for r in records.campaign.estimated if r.leading == "torque")
    yield Finding(
        (),
        "unit of all records",
        f"measured torque is about {1.0 / found[0]:.3g} times the simulated torque at every start point",
        f"mechid does not change all records by itself: write {' or '.join(unit_remedy(record, k) for k in found)}, or "
        "look for a wrong unit in the mechanism file",
        Confidence.AMBIGUOUS if len(found) > 1 else Confidence.CONFIRMED,
    )


def _level_finding(size: str) -> Finding:
    return Finding(
        (),
        "level",
        f"measured torque is {size} than the simulated torque at every start point, and no usual unit of torque makes "
        "the first steps fit",
        "check how their numbers were read (raw counts, a scale factor, decimal and thousands marks), or look for a "
        "wrong unit in the mechanism file",
    )


def _unexplained_finding(name: str) -> Finding:
    return Finding(
        (name,),
        UNEXPLAINED,
        "its spectrum is not that of its declaration, and no other rate, stepping or unit that was tried makes its "
        "first steps fit",
        "check how its numbers and times were read (mechid look), and its entry in the campaign file",
    )


def _unstable_finding(points: int) -> Finding:
    return Finding(
        (),
        "unstable model",
        f"at {points} of {RULES.box_points} starts within the bounds the model has modes too fast to be simulated",
        "look for a wrong unit in the mechanism file, of a value or of its bounds",
    )


def _low_pass_finding(cut_off_hz: Mapping[str, float]) -> Finding:
    """Report a low-pass; the frequency is that of a coarse grid, and mostly above the filter's own."""
    return Finding(
        tuple(cut_off_hz),
        "low-pass",
        f"the spectrum falls as behind a low-pass below about {max(cut_off_hz.values()):g} Hz, and the mechanism file "
        "declares none",
        "if the recorder or its amplifier has one, write [anti_alias] with order and frequency (rad/s) in the "
        "mechanism file, or record through a wider one",
    )
