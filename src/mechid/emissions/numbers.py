"""Numbers of an emission verdict in one plain dict: the content of emission.json."""

from __future__ import annotations

import math
import platform
from collections.abc import Mapping
from importlib.metadata import version
from typing import Any

from mechid.budgets.prediction_numbers import prediction_numbers
from mechid.emissions.emission import Assessment, AtRate, Emission
from mechid.emissions.emission_line import EmissionLine
from mechid.emissions.predicted import PredictedEmission
from mechid.emissions.trust import BenchUse
from mechid.identification.result.estimate_file import DIGEST
from mechid.ink.digits import plain, with_sigma
from mechid.records import ChannelSpec
from mechid.specification.numbers import VERDICT_WORDS, finite, requirement_numbers, worst_numbers, worst_texts
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
        "prediction": _prediction(found.predicted),
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
    worst, records = one.deciding.worst or one.judged.worst, one.judged
    own = one.prediction and prediction_numbers(one.prediction)
    text = {
        "verdict": VERDICT_WORDS[one.verdict],
        "records": VERDICT_WORDS[records.verdict],
        "predicted": VERDICT_WORDS[one.prediction.verdict] if one.prediction else "",
        "unit": unit_words(one.requirement.unit),
        **worst_texts(worst),
    }
    return {
        **requirement_numbers(one.requirement),
        "definition": definition_of(one.requirement),
        "verdict": one.verdict.value,
        "judged_Hz": list(one.judged_hz) if one.judged_hz else None,
        "worst": worst_numbers(worst),
        "records": {"verdict": records.verdict.value, "worst": worst_numbers(records.worst)},
        "predicted": own,
        "at_rates": [_at_rate(at) for at in one.at_rates],
        "text": text,
    }


def _prediction(predicted: PredictedEmission | None) -> dict[str, Any] | None:
    """Return the origin and the range of the predictions; None without a fit."""
    if predicted is None:
        return None
    return {
        "fit": predicted.source,
        DIGEST: predicted.digest or None,
        "values": predicted.place,
        "highest_Hz": finite(predicted.highest_hz),
        "rates": [
            {"stepping": name, "from": low, "to": high, "count": count, "tested": tested}
            for name, (low, high, count, tested) in predicted.rates.items()
        ],
        "orders": [
            {
                "stepping": curve.stepping,
                "order": curve.order,
                "rates": curve.rates.tolist(),
                "amplitude": [finite(value) for value in curve.amplitude.tolist()],
                "bound95": [finite(value) for value in curve.bound.tolist()],
                "measured": [
                    {"rate": rate, "amplitude": amplitude, "sigma": sigma}
                    for rate, amplitude, sigma in curve.measured.tolist()
                ],
            }
            for curve in predicted.curves
        ],
    }


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
        "named": one.named,
        "mains_Hz": finite(one.mains_hz),
        "amplitude": one.amplitude,
        "sigma": one.sigma,
        "background": one.background,
        "unit": one.unit,
        "text": {"frequency_Hz": plain(one.frequency_hz, 5), "amplitude": amplitude, "sigma": sigma},
    }
