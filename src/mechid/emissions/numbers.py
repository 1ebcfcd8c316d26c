"""Numbers of an emission verdict in one plain dict: the content of emission.json."""

from __future__ import annotations

import math
import platform
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

from mechid.emissions.emission import Assessment, AtRate, Emission, EmissionLine
from mechid.emissions.trust import BenchUse
from mechid.ink.digits import plain, with_sigma
from mechid.records import ChannelSpec
from mechid.specification.numbers import VERDICT_WORDS, finite, worst_numbers, worst_texts
from mechid.specification.requirement import AMPLITUDE, BAND_PEAK, PSD, RMS, THIRD_OCTAVE, Requirement
from mechid.specification.settings import SPECIFICATION
from mechid.specification.verdict import Judged

FORMAT = "mechid-emission/1"
DEFINITIONS: Mapping[str, str] = {
    AMPLITUDE: "peak value of a sine (not RMS), one-sided; root mean square over Hann windows without overlap; Rice "
    "bias removed",
    RMS: "RMS in each band of the mask, one-sided density under Hann windows, half overlap",
    PSD: "one-sided power density, Hann window, half overlap, bins of {resolution:g} Hz (noise bandwidth 1.5 bins)",
    THIRD_OCTAVE: "RMS in third octaves of base ten (IEC 61260-1), one-sided density under Hann windows, half overlap",
    BAND_PEAK: "largest instantaneous magnitude in each band of the mask (not RMS), Butterworth band-pass of order "
    f"{SPECIFICATION.filter_order}, forward",
}


def emission_numbers(found: Emission) -> dict[str, Any]:
    """Return all that `mechid emission` shows."""
    return {
        "format": FORMAT,
        "synthetic": found.synthetic,
        "requirements": [_assessment(one) for one in found.assessments],
        "lines": [_line(one) for one in found.lines],
        "usable_band_Hz": [finite(value) for value in found.usable_hz],
        "directions": _directions(found),
        "bench": _bench(found.bench),
        "backgrounds": [
            {"direction": one.direction, "record": one.record, "rms": one.rms, "unit": one.unit}
            for one in found.backgrounds
        ],
        "notes": list(found.notes),
        "test": found.test.to_dict(),
        "channels": _channels(found),
        "provenance": {
            "versions": {"mechid": version("mechid"), "python": platform.python_version()},
            "inputs_sha256": dict(found.inputs),
        },
        "sources": [
            {
                "name": one.name,
                "file": one.file,
                "sha256": one.sha256,
                "state": one.state,
                "sample_rate_hz": one.sample_rate_hz,
                "duration_s": one.duration_s,
                "rates": [finite(rate) for rate in one.rates],
                "command": one.command,
                "started": one.started,
            }
            for one in found.sources
        ],
    }


def unit_words(unit: str) -> str:
    """Return a unit as a page shows it.

    Examples
    --------
    >>> unit_words("N^2*m^2/Hz")
    'N² m²/Hz'
    """
    return unit.replace("*", " ").replace("^2", "²")


def definition_of(requirement: Requirement) -> str:
    """Return how the quantity of a requirement is defined."""
    return DEFINITIONS[requirement.kind].format(resolution=requirement.resolution_hz)


def _directions(found: Emission) -> list[dict[str, Any]]:
    """Return the directions that were measured, each with its unit and the step rates at which it was."""
    named = dict.fromkeys((one.direction, one.unit) for one in found.spectra)
    rates = {
        name: sorted({abs(one.rate) for one in found.spectra if one.direction == name and math.isfinite(one.rate)})
        for name, _ in named
    }
    bands = {name: found.bands_hz.get(name, found.usable_hz) for name, _ in named}
    return [
        {
            "name": name,
            "unit": unit,
            "rates": rates[name],
            "usable_band_Hz": [finite(f) for f in bands[name]],
            "text": {"unit": unit_words(unit)},
        }
        for name, unit in named
    ]


def _bench(use: BenchUse) -> dict[str, Any]:
    return {
        "calibration": use.calibration or None,
        "calibration_uncertainty_percent": 100.0 * use.calibration_error if use.calibration else None,
        "table_response": use.response or None,
        "interface_point_m": list(use.point_m) if use.point_m else None,
        "bands_Hz": {name: [finite(f) for f in band] for name, band in use.bands_hz.items()},
        "trusted_Hz": finite(use.trusted_hz),
        "reason": use.reason,
    }


def _channels(found: Emission) -> list[dict[str, Any]]:
    """Return the channels as declared, each once, with the records that have it."""
    rows: dict[ChannelSpec, list[str]] = {}
    for source in found.sources:
        for channel in source.channels:
            rows.setdefault(channel, []).append(source.name)
    return [{**channel.to_dict(), "records": names} for channel, names in rows.items()]


def _assessment(one: Assessment) -> dict[str, Any]:
    requirement, worst = one.requirement, one.judged.worst
    text = {"verdict": VERDICT_WORDS[one.verdict], "unit": unit_words(requirement.unit), **worst_texts(worst)}
    return {
        "name": requirement.name,
        "direction": requirement.direction,
        "kind": requirement.kind,
        "definition": definition_of(requirement),
        "verdict": one.verdict.value,
        "unit": requirement.unit,
        "confidence": requirement.confidence,
        "margin_dB_required": requirement.margin_db,
        "exclude_mains": requirement.exclude_mains,
        "mask": [list(point) for point in zip(*_mask(requirement), strict=True)],
        "interpolation": "step" if requirement.mask.is_stepwise else "log-log",
        "judged_Hz": list(one.judged_hz) if one.judged_hz else None,
        "worst": worst_numbers(worst),
        "at_rates": [_at_rate(at) for at in one.at_rates],
        "text": text,
    }


def _mask(requirement: Requirement) -> tuple[list[float], list[float]]:
    return requirement.mask.frequencies_hz.tolist(), requirement.mask.limits.tolist()


def _at_rate(at: AtRate) -> dict[str, Any]:
    judged: Judged = at.judged
    return {
        "record": at.record,
        "rate": finite(at.rate),
        "verdict": judged.verdict.value,
        "worst": worst_numbers(judged.worst),
        "text": {
            "rate": plain(finite(at.rate), 5),
            "verdict": VERDICT_WORDS[judged.verdict],
            **worst_texts(judged.worst),
        },
    }


def _line(one: EmissionLine) -> dict[str, Any]:
    amplitude, sigma = with_sigma(one.amplitude, one.sigma)
    return {
        "record": one.record,
        "rate": finite(one.rate),
        "direction": one.direction,
        "frequency_Hz": one.frequency_hz,
        "order": finite(one.order),
        "mains_Hz": finite(one.mains_hz),
        "amplitude": one.amplitude,
        "sigma": one.sigma,
        "background": one.background,
        "unit": one.unit,
        "text": {"frequency_Hz": plain(one.frequency_hz, 5), "amplitude": amplitude, "sigma": sigma},
    }
