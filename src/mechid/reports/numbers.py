"""Numbers of a fit with their texts in one plain dict, which printers show without further computation."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from mechid.analysis.validation import RecordValidation
from mechid.campaign.campaign import is_start_name
from mechid.diagnoses.effect_rows import missing_data
from mechid.diagnoses.path import completed_data
from mechid.identification.result.fit import Fit, StageReport
from mechid.identification.result.grade import CAUSE_WORDS, Reason, grade_words
from mechid.identification.result.parameter_estimate import ParameterEstimate, PriorShare
from mechid.identification.result.record_result import ChannelFit, MaskedMoment, RecordFit
from mechid.ink.digits import digits, like, plain, with_sigma
from mechid.ink.quantities import quantity_words
from mechid.parameter import Status
from mechid.reports.added_effects import residual_lines
from mechid.reports.side import side_rows
from mechid.reports.use import with_left_out, with_use
from mechid.units import angle_difference, unit_words
from mechid.validations.numbers import order_rows, validation_rows

FORMAT = "mechid-report/1"


def report_data(
    fit: Fit,
    truth: Mapping[str, float] | None = None,
    *,
    synthetic: bool = False,
    validation: Mapping[str, RecordValidation] | None = None,
) -> dict[str, Any]:
    """Return all numbers of the report of a fit.

    Parameters
    ----------
    fit : Fit
    truth : mapping of dotted name to float, or None
        True values in the file's units, known for synthetic campaigns only.
    synthetic : bool
        Whether the records were simulated, which every report then states.
    validation : mapping or None
        Of the records, as `validate` makes it.

    Returns
    -------
    dict
        Numbers, with texts of those that need rounding; JSON-serialisable.
    """
    truth = truth or {}
    left_out = {name for name, r in fit.records.items() if r.reading.left_out}
    channels = [_channel(r, quantity, c) for r in fit.records.values() for quantity, c in r.channels.items()]
    return {
        "format": FORMAT,
        "synthetic": fit.synthetic or synthetic,
        "grade": str(fit.grade),
        "grade_words": grade_words(fit.grade, fit.outcome),
        "reasons": [_reason(reason) for reason in fit.reasons],
        "outcome": {"code": fit.outcome.code, "message": fit.outcome.value, "path": list(fit.path)},
        "has_truth": bool(truth),
        "parameters": [_parameter(p, truth.get(name)) for name, p in fit.parameters.items() if not is_start_name(name)],
        "records": with_use([_record(r) for r in fit.records.values()], left_out),
        "channels": with_use(channels, left_out),
        "validation": with_left_out(validation_rows(validation or {}), left_out),
        "orders": with_left_out(order_rows(validation or {}), left_out),
        "side": side_rows(validation or {}),
        "stages": [_stage(s) for s in fit.stages],
        "arrived": f"How the search arrived: {', then '.join(fit.path)}." if fit.path else "",
        "missing": [missing_data(one) for one in fit.missing],
        "as_written": fit.as_written.to_dict() if fit.as_written else None,
        "lacking": residual_lines(fit),
        "completed": completed_data(fit.completed),
        "warnings": list(fit.warnings),
        "notes": list(fit.notes),
        "provenance": dict(fit.provenance),
    }


def _reason(reason: Reason) -> dict[str, Any]:
    """Return a reason for the grade of a fit, with the cause as code and in words."""
    return {**reason.to_dict(), "words": CAUSE_WORDS[reason.cause]}


def _parameter(p: ParameterEstimate, truth: float | None) -> dict[str, Any]:
    estimate, sigma = with_sigma(p.value, p.std_error)
    deviation = _deviation(p, truth)
    table, _, key = p.name.rpartition(".")
    return {
        "name": p.name,
        "table": table,
        "key": key,
        "symbol": p.symbol,
        "unit": p.unit,
        "nominal": p.start,
        "estimate": p.value,
        "std_error": p.std_error,
        "std_error_noise": p.std_error_noise,
        "std_error_white": p.std_error_white,
        "std_error_clock": p.std_error_clock,
        "ci95": list(p.ci95) if p.ci95 else None,
        "truth": truth,
        "deviation_sigmas": deviation,
        "min": p.min,
        "max": p.max,
        "status": p.status,
        "reason": p.reason,
        "added": p.added,
        "local_only": p.local_only,
        "contradicted": p.contradicted,
        "prior": asdict(p.prior) if p.prior else None,
        "estimated": p.status != Status.KNOWN,
        "text": {
            "nominal": plain(p.start),
            "estimate": estimate,
            "std_error": sigma,
            "truth": "" if truth is None else like(truth, p.std_error),
            "deviation_sigmas": "" if deviation is None else f"{deviation:+.1f}",
            "unit": "" if p.unit == "1" else p.unit,
            "min": "" if p.min is None else plain(p.min),
            "max": "" if p.max is None else plain(p.max),
            "status": _status(p),
            "prior": "" if p.prior is None else plain(p.prior.value),
            "prior_sigma": "" if p.prior is None else plain(p.prior.sigma),
            "without_prior": "" if p.prior is None else _records_alone(p.prior),
        },
    }


def _status(p: ParameterEstimate) -> str:
    """Return a parameter's status in words, and whether the fit added it."""
    words = "near threshold" if p.local_only else p.status.replace("_", " ")
    return f"{words}, added" if p.added else words


def _records_alone(prior: PriorShare) -> str:
    """Return the standard error that the records alone would give, as text."""
    return "not known" if prior.std_error_without == math.inf else digits(prior.std_error_without, 3)


def _deviation(p: ParameterEstimate, truth: float | None) -> float | None:
    """Return (estimate - truth) / sigma, for angles of the shorter way round; None without a sigma."""
    if truth is None or not p.std_error:
        return None
    difference = angle_difference(p.value, truth) if p.unit == "deg" else p.value - truth
    return difference / p.std_error


def _record(r: RecordFit) -> dict[str, Any]:
    return {
        "name": r.name,
        "use": r.use,
        "samples": r.samples,
        "fit_percent": r.fit_percent,
        "residual_rms": r.residual_rms,
        "noise_sigma": r.noise_sigma,
        "noise_rests_on": r.noise_rests_on,
        "noise_known": r.noise_known,
        "offset": r.offset,
        "drift": r.drift,
        "followed_percent": r.followed_percent,
        "residual_over_noise": r.residual_over_noise,
        "horizon_s": r.horizon_s,
        "prefilter_order": r.prefilter_order,
        "rejected": r.rejected,
        "masked": [asdict(moment) for moment in r.masked],
        "channels": list(r.channels),
        "text": {
            "samples": _samples(r.samples, r.masked),
            "fit_percent": digits(r.fit_percent, 4),
            "residual_rms": digits(r.residual_rms, 3),
            "noise_sigma": digits(r.noise_sigma, 3),
            "noise_known": digits(r.noise_known, 3),
            "offset": digits(r.offset, 3),
            "drift": digits(r.drift, 3),
            "followed_percent": plain(r.followed_percent, 4),
        },
    }


def _samples(samples: int, masked: tuple[MaskedMoment, ...]) -> str:
    """Return a number of samples, and how much of the record the search left out."""
    left_out_s = sum(moment.to_s - moment.from_s for moment in masked)
    return f"{samples}, {1e3 * left_out_s:.3g} ms left out" if masked else str(samples)


def _channel(r: RecordFit, quantity: str, c: ChannelFit) -> dict[str, Any]:
    unit = unit_words(quantity)
    return {
        "name": r.name,
        "quantity": quantity,
        "unit": unit,
        "use": c.use,
        "samples": r.samples - c.rejected,
        "fit_percent": c.fit_percent,
        "residual_rms": c.residual_rms,
        "noise_sigma": c.noise_sigma,
        "noise_rests_on": c.noise_rests_on,
        "noise_known": c.initial_noise,
        "offset": c.offset,
        "drift": c.drift,
        "quantisation": c.quantisation,
        "prefilter_order": c.prefilter_order,
        "rejected": c.rejected,
        "masked": [asdict(moment) for moment in c.masked],
        "followed_percent": c.followed_percent,
        "lost_at_s": c.lost_at_s,
        "out_of_step_at_s": c.out_of_step_at_s,
        "text": {
            "quantity": quantity_words(quantity),
            "unit": unit,
            "samples": _samples(r.samples - c.rejected, c.masked),
            "fit_percent": digits(c.fit_percent, 4),
            "residual_rms": digits(c.residual_rms, 3),
            "noise_sigma": digits(c.noise_sigma, 3),
            "noise_known": digits(c.initial_noise, 3),
            "offset": digits(c.offset, 3),
            "drift": digits(c.drift, 3),
            "followed_percent": plain(c.followed_percent, 4),
        },
    }


def _stage(s: StageReport) -> dict[str, Any]:
    return {
        "name": s.name,
        "records": dict(s.records),
        "free": list(s.free),
        "cost": s.cost,
        "evaluations": s.evaluations,
        "seconds": s.seconds,
        "note": s.note,
        "text": {
            "records": f"{len(s.records)}",
            "record_s": plain(sum(s.records.values())),
            "free": f"{len(s.free)}",
            "cost": digits(s.cost, 6),
            "evaluations": f"{s.evaluations}",
            "seconds": f"{s.seconds:.1f}",
        },
    }
