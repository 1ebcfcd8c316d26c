"""Numbers of a quiet drive in one dict: quiet.json."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.prediction import Prediction
from mechid.identification.result.estimate_file import provenance_of_fits
from mechid.ink.digits import digits
from mechid.quiet_drives.confirmation import Confirmation
from mechid.quiet_drives.improvement import Gain, LineAt
from mechid.quiet_drives.quiet_drive import QuietDrive
from mechid.quiet_drives.rate_survey import FORBIDDEN, RECOMMENDED, Band, Pair, SteppingCurve, widest_bands
from mechid.quiet_drives.rounding import largest_code
from mechid.quiet_drives.settings import QUIET

FORMAT = "mechid-quiet/1"
FILE_NAME = "quiet.json"
TORQUE_UNIT = "N*m"
SHOWN_ORDERS = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0)


def quiet_numbers(found: QuietDrive) -> dict[str, Any]:
    """Return the numbers shown for a quiet drive, SI units unless a key says otherwise, with formatted texts."""
    design, better, rounded = found.design, found.improvement, found.rounded
    return {
        "format": FORMAT,
        "fit": found.source,
        "grade": found.grade,
        "synthetic": found.synthetic,
        "rates": list(design.rates),
        "orders": list(design.orders),
        "level_unit": design.quantity.unit,
        "lines_of_sight": list(structure.line_of_sight) if (structure := design.quantity.structure) else [],
        "range": list(design.ends or ()),
        "microsteps": design.microsteps,
        "table": {
            "steps_per_period": len(found.table),
            "values": found.table.tolist(),
            "exact": found.exact.tolist(),
            "nominal": found.nominal.tolist(),
            "bits": rounded.bits,
            "codes": rounded.codes.tolist(),
            "largest_code": largest_code(rounded.bits),
            "full_scale": rounded.full_scale,
            "kept_share": found.kept_share,
            "cost": _number(rounded.cost),
            "cost_plain_rounding": _number(rounded.plain_cost),
            "search_cpu_s": found.cpu_s,
        },
        "before": [_line(one) for one in better.before],
        "after": [_line(one) for one in better.after],
        "lines": _lines_beside(found),
        "gains": [_gain(one) for one in better.gains],
        "sensitivity": [
            {"name": name, "change_db": value, "text": {"change_db": _db(value)}}
            for name, value in sorted(better.sensitivity.items(), key=lambda pair: pair[1])
        ],
        "units": {name: [_gain(one) for one in gains] for name, gains in better.units.items()},
        "worst_rise": {"rise_db": _number(found.worst_rise_db), "rate": found.worst_rate},
        "margins": [
            {
                "rate": one.rate,
                "nominal_Nm": one.nominal_Nm,
                "table_Nm": one.table_Nm,
                "share": one.share,
                "text": {
                    "rate": f"{one.rate:g}",
                    "nominal": digits(one.nominal_Nm, 3),
                    "table": digits(one.table_Nm, 3),
                    "share": f"{100.0 * one.share:.0f} %",
                },
            }
            for one in found.reserves
        ],
        "survey": {
            "limit": found.survey.limit,
            "curves": [_curve(one) for one in found.survey.curves],
            "bands": [_band(one) for one in found.survey.bands],
            "recommended": [_band(one) for one in widest_bands(found.survey)],
            "forbidden": [_band(one) for one in widest_bands(found.survey, FORBIDDEN)],
            "pairs": [_pair(one) for one in found.survey.pairs],
        },
        "requirements": _requirements(found.predictions),
        "drivers": [
            {
                "driver": one.driver,
                "registers": dict(one.registers),
                "gains_db": [{"rate": rate, "gain_db": gain} for rate, gain in one.gains_db.items()],
                "note": one.note,
                "text": {"gains": ", ".join(f"{gain:.1f}" for gain in one.gains_db.values()) or "-"},
            }
            for one in found.drivers
        ],
        "confirmations": [_confirmation(one, found) for one in found.confirmations],
        "warnings": list(_warnings(found)),
        "provenance": provenance_of_fits(found.digest),
    }


def _line(one: LineAt) -> dict[str, Any]:
    # The bound is a one-sided 95 % quantile; sigma is the standard error that gives it in a normal distribution.
    sigma = max(one.bound - one.amplitude, 0.0) / 1.645
    return {
        "rate": one.rate,
        "order": one.order,
        "amplitude": one.amplitude,
        "sigma": sigma,
        "bound": one.bound,
        "unit": TORQUE_UNIT,
    }


def _lines_beside(found: QuietDrive) -> list[dict[str, Any]]:
    """Return the shown orders at each design rate, before beside after."""
    after = {(one.rate, one.order): one for one in found.improvement.after}
    wanted = sorted({*SHOWN_ORDERS, *found.design.orders})
    out = []
    for one in found.improvement.before:
        other = after.get((one.rate, one.order))
        if other is None or one.order not in wanted:
            continue
        reduction = _gain_text(one.amplitude, other.amplitude)
        texts = {
            "rate": f"{one.rate:g}",
            "order": f"{one.order:g}",
            "before": digits(one.amplitude, 3),
            "before_bound": digits(one.bound, 3),
            "after": digits(other.amplitude, 3),
            "after_bound": digits(other.bound, 3),
            "reduction": reduction,
        }
        out.append({"rate": one.rate, "order": one.order, "text": texts})
    return out


def _confirmation(one: Confirmation, found: QuietDrive) -> dict[str, Any]:
    too_long = one.seconds > QUIET.longest_confirming_s
    command = f'stepping = "micro", microsteps = {len(found.table) // 4}, table = "table.csv", rate = {one.rate:g}'
    return {
        "rate": one.rate,
        "seconds": one.seconds,
        "command": command,
        "text": {
            "rate": f"{one.rate:g}",
            "seconds": "over an hour: quieter than this bench" if too_long else digits(max(one.seconds, 0.1), 2),
        },
    }


def _gain(one: Gain) -> dict[str, Any]:
    return {
        "rate": one.rate,
        "before": one.before,
        "after": one.after,
        "gain_db": one.gain_db,
        "bound_db": one.bound_db,
        "text": {
            "rate": f"{one.rate:g}",
            "before": digits(one.before, 3),
            "after": digits(one.after, 3),
            "gain": _db(one.gain_db),
            "bound": _db(one.bound_db),
        },
    }


def _curve(one: SteppingCurve) -> dict[str, Any]:
    return {
        "stepping": one.stepping,
        "rates": one.rates.tolist(),
        "level": _column(one.level),
        "bound": _column(one.bound),
        "verdicts": list(one.verdicts),
    }


def _band(one: Band) -> dict[str, Any]:
    return {
        "stepping": one.stepping,
        "verdict": one.verdict,
        "low": one.low,
        "high": one.high,
        "worst": _number(one.worst),
        "text": {
            "low": f"{one.low:.4g}",
            "high": f"{one.high:.4g}",
            "worst": digits(one.worst, 3) if math.isfinite(one.worst) else "-",
        },
    }


def _pair(one: Pair) -> dict[str, Any]:
    return {
        "mean": one.mean,
        "low": one.low,
        "high": one.high,
        "share": one.share,
        "stepping": one.stepping,
        "rms": one.rms,
        "alone": _number(one.alone),
        "text": {
            "mean": f"{one.mean:.4g}",
            "low": f"{one.low:.4g}",
            "high": f"{one.high:.4g}",
            "share": f"{100.0 * one.share:.0f} %",
            "rms": digits(one.rms, 3),
            "alone": digits(one.alone, 3) if math.isfinite(one.alone) else "-",
        },
    }


def _requirements(predictions: Mapping[str, tuple[Prediction, ...]]) -> list[dict[str, Any]]:
    names = [one.requirement.name for one in next(iter(predictions.values()), ())]
    return [
        {"name": name, **{table: str(own[k].verdict) for table, own in predictions.items()}}
        for k, name in enumerate(names)
    ]


def _warnings(found: QuietDrive) -> list[str]:
    out = []
    if found.worst_rise_db > 1.0:
        out.append(
            f"At {found.worst_rate:.4g} full steps/s the table is {found.worst_rise_db:.1f} dB louder than the nominal "
            "one; narrow range, or give fewer rates."
        )
    if found.kept_share < 1.0:
        out.append(
            f"The torque reserve allows {100.0 * found.kept_share:.0f} % of the change that the search found; lower "
            "drive.pull_out_share to use more."
        )
    least = min((one.share for one in found.reserves), default=1.0)
    if least < found.design.pull_out_share:
        out.append(
            f"With these codes the torque reserve is {100.0 * least:.1f} % of the nominal table's, below "
            "drive.pull_out_share; allow more bits."
        )
    if found.improvement.uncovered_share > QUIET.most_uncovered:
        out.append(
            f"{100.0 * found.improvement.uncovered_share:.0f} % of the RMS torque is at frequencies that the structure "
            "does not cover; these lines do not count."
        )
    silent = [curve.stepping for curve in found.survey.curves if RECOMMENDED not in curve.verdicts]
    if silent:
        out.append(f"No rate is recommended in {', '.join(silent)}.")
    return out


def _db(value: float) -> str:
    return f"{value:.1f}"


def _gain_text(before: float, after: float) -> str:
    return _db(20.0 * math.log10(before / after)) if before > 0.0 and after > 0.0 else "-"


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _column(values: FloatArray) -> list[float | None]:
    return [_number(float(value)) for value in np.asarray(values)]
