"""Results of a survey of records, with their texts, as one plain dict: the content of look.json."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from mechid.analysis.attributed_lines import AttributedLine
from mechid.analysis.look import ChannelLook, Drive, RecordLook
from mechid.analysis.measured_resonances import MeasuredResonance
from mechid.analysis.order_tracking import OrderLine
from mechid.analysis.settings import ORDER
from mechid.analysis.shared_resonances import SharedResonance, shared_resonances
from mechid.analysis.step_lines import NamedStepLine, StepLine
from mechid.analysis.survey import Survey
from mechid.command.words import command_words
from mechid.ink.digits import digits, plain, with_sigma
from mechid.looks.words import (
    channel_words,
    driven_words,
    mains_word,
    order_name,
    resonance_word,
    unit_text,
)
from mechid.records.channel_keys import channel_keys
from mechid.records.step_rate import RateReading, SuggestedRate, read_declared_rate
from mechid.signal.moments import extremes
from mechid.signal.runs import Runs

FORMAT = "mechid-look/1"
SHOWN = 8
"""Largest number of gaps, clipped peaks and quiet stretches listed individually."""


def look_numbers(found: Survey) -> dict[str, Any]:
    """Return all results that `mechid look` shows."""
    return {
        "format": FORMAT,
        "records": [_record(look) for look in found.looks],
        "resonances": [_shared_resonance(one) for one in shared_resonances(found.looks)],
        "left_out": [asdict(one) for one in found.left_out],
    }


def _record(look: RecordLook) -> dict[str, Any]:
    record, base = look.record, look.base
    declared, suggested = look.declared, look.suggested
    reading = _rate_reading(declared, suggested)
    driven = {
        "declared": _declared_drive(declared) if declared else None,
        "suggested": _suggested_drive(suggested) if suggested else None,
        "reading": {"rate": reading.rate, "sigma": reading.sigma, "repeats": reading.repeats} if reading else None,
    }
    return {
        "name": record.name,
        "file": str(record.path),
        "sha256": record.digest,
        "start_time": record.start_time,
        "samples": record.samples,
        "sample_rate_hz": base.sample_rate_hz,
        "start_s": base.start_s,
        "duration_s": record.duration_s,
        "treatments": [str(treatment["text"]) for treatment in record.treatments],
        "warnings": list(record.warnings),
        "driven": {**driven, "words": driven_words(driven)},
        "channels": [
            _channel(one, key, look) for one, key in zip(look.channels, channel_keys(look.record), strict=True)
        ],
        "text": {
            "samples": str(record.samples),
            "sample_rate_hz": plain(base.sample_rate_hz, 9),
            "duration_s": plain(record.duration_s, 6),
        },
    }


def _rate_reading(declared: Drive | None, suggested: SuggestedRate | None) -> RateReading | None:
    """Return the record's own measurement of the declared rate, if both are constant."""
    if not declared or not suggested or not suggested.is_constant:
        return None
    # A record does not show the direction of rotation.
    rates = {abs(rate) for rate in declared.command.rate.rates}
    return read_declared_rate(suggested, rates.pop()) if len(rates) == 1 else None


def _declared_drive(drive: Drive) -> dict[str, Any]:
    rate = drive.command.rate
    return {
        "stepping": drive.command.stepping,
        "microsteps": drive.command.microsteps,
        "times_s": list(rate.times_s),
        "rates": list(rate.rates),
        "time_offset_s": drive.time_offset_s,
        "words": command_words(drive.command),
    }


def _suggested_drive(found: SuggestedRate) -> dict[str, Any]:
    return {
        "times_s": list(found.profile.times_s),
        "rates": list(found.profile.rates),
        "sigma": found.sigma,
        "repetition_hz": found.repetition_hz,
        "stepping": found.stepping,
        "microsteps": found.microsteps,
        "others": list(found.others),
        "share": found.share,
    }


def _channel(look: ChannelLook, key: str, record: RecordLook) -> dict[str, Any]:
    channel, start, fs = look.channel, record.base.start_s, record.base.sample_rate_hz
    low, high = extremes(channel.data)
    numbers = {
        "min": low,
        "max": high,
        "mean": look.mean,
        "rms": look.rms,
        "drift": look.drift,
    }
    noise = look.noise
    data: dict[str, Any] = {
        "key": key,
        "quantity": channel.quantity,
        "column": channel.column,
        "unit": unit_text(channel.unit),
        **numbers,
        "gaps": _runs(look.gaps, start, fs),
        "clipped": _runs(look.clipped, start, fs),
        "spikes": {"count": int(look.spikes.size), "first_at_s": (start + look.spikes[:SHOWN] / fs).tolist()},
        "quiet": [
            {"from_s": start + q.first / fs, "to_s": start + q.stop / fs, "rms": q.rms} for q in look.quiet[:SHOWN]
        ],
        "noise": {
            "sigma": noise.sigma,
            "rests_on": noise.rests_on,
            "floor": noise.floor,
            "quiet_rms": noise.quiet,
            "resolution": noise.resolution,
        },
        "lines": [_line(one) for one in look.lines],
        "mains": [_line(one) for one in look.mains],
        "step_lines": [_step_line(one) for one in look.step_lines],
        "named_lines": [_named_line(one) for one in look.named_lines],
        "over_rate": [_order_line(one) for one in look.over_rate],
        "third_octaves": [
            {"centre_hz": b.centre_hz, "lower_hz": b.lower_hz, "upper_hz": b.upper_hz, "rms": b.rms} for b in look.bands
        ],
        "below_rms": look.below_rms,
        "resonances": [_resonance(one) for one in look.resonances],
        "text": {name: digits(value, 4) for name, value in numbers.items()} | {"noise": digits(noise.sigma, 3)},
    }
    return data | {"words": channel_words(data, rate_known=record.rate is not None)}


def _runs(runs: Runs, start_s: float, sample_rate_hz: float) -> dict[str, Any]:
    lengths = [stop - first for first, stop in runs]
    return {
        "count": len(runs),
        "samples": sum(lengths),
        "longest_s": max(lengths, default=0) / sample_rate_hz,
        "first_at_s": [start_s + first / sample_rate_hz for first, _ in runs[:SHOWN]],
    }


def _line(seen: AttributedLine) -> dict[str, Any]:
    line, mains = seen.line, seen.mains
    amplitude, sigma = with_sigma(line.amplitude, line.sigma)
    data: dict[str, Any] = {
        "frequency_hz": line.frequency_hz,
        "amplitude": line.amplitude,
        "sigma": line.sigma,
        "ratio": line.ratio,
        "order": seen.order,
        "mains_hz": mains.mains_hz if mains else None,
        "mains_multiple": mains.multiple if mains else None,
        "named": [one.name for one in seen.named],
    }
    words = ", or ".join(filter(None, (order_name(seen.order), *data["named"], mains_word(data))))
    text = {
        "frequency_hz": plain(line.frequency_hz, 6),
        "amplitude": amplitude,
        "sigma": sigma,
        "ratio": plain(line.ratio, 3),
        "what": words,
    }
    return data | {"text": text}


def _step_line(line: StepLine) -> dict[str, Any]:
    amplitude, sigma = with_sigma(line.amplitude, line.sigma)
    resolved = line.amplitude > ORDER.resolved * line.sigma
    # An unresolved line is given as the limit below which it must lie.
    least = f"below {digits(ORDER.resolved * line.sigma, 2)}"
    text = {
        "order": plain(line.order, 4),
        "amplitude": amplitude if resolved else least,
        "sigma": sigma if resolved else "",
        "peak_rate": plain(line.peak_rate, 4) if resolved else "",
        "peak_amplitude": digits(line.peak_amplitude, 3) if resolved else "",
    }
    return {
        "order": line.order,
        "windows": line.windows,
        "amplitude": line.amplitude,
        "sigma": line.sigma,
        "peak_rate": line.peak_rate,
        "peak_amplitude": line.peak_amplitude,
        "text": text,
    }


def _named_line(line: NamedStepLine) -> dict[str, Any]:
    amplitude, sigma = with_sigma(line.amplitude, line.sigma)
    resolved = line.amplitude > ORDER.resolved * line.sigma
    text = {
        "names": " or ".join(line.names),
        "order": plain(line.order, 6),
        "per_turn": plain(line.per_turn, 6),
        # An unresolved line is given as the limit below which it must lie.
        "amplitude": amplitude if resolved else f"below {digits(ORDER.resolved * line.sigma, 2)}",
        "sigma": sigma if resolved else "",
    }
    return {
        "names": list(line.names),
        "words": line.words,
        "order": line.order,
        "per_turn": line.per_turn,
        "windows": line.windows,
        "amplitude": line.amplitude,
        "sigma": line.sigma,
        "text": text,
    }


def _order_line(line: OrderLine) -> dict[str, float]:
    """Return one order in one window: amplitude with the noise subtracted, and the error of its parts."""
    return {
        "order": line.order,
        "rate": line.rate,
        "amplitude": float(np.sqrt(max(line.power(), 0.0))),
        "sigma": line.errors[0],
    }


def _resonance(found: MeasuredResonance) -> dict[str, Any]:
    data = {
        "frequency_hz": found.frequency_hz,
        "spread_hz": found.spread_hz,
        "orders": list(found.orders),
        "hump": found.hump,
    }
    return data | {"words": resonance_word(data)}


def _shared_resonance(one: SharedResonance) -> dict[str, Any]:
    words = f"{digits(one.frequency_hz, 3)} Hz in {', '.join(one.records)}"
    return {"frequency_hz": one.frequency_hz, "records": list(one.records), "words": words}
