"""Residual spectra of several fits: RMS of the residual of each torque record by third octave."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mechid.analysis.hypothesis import Hypothesis
from mechid.arrays import FloatArray
from mechid.errors import InputFileError

if TYPE_CHECKING:
    from mechid.analysis.residual_emission import ResidualAtRate
    from mechid.analysis.residual_file import ResidualRecord

THIRDS_A_DECADE = 10
WIDTH = 10.0**0.05 - 10.0**-0.05
"""Width of a third octave relative to its centre."""
DIGITS = 5


def residual_spectra(hypotheses: Sequence[Hypothesis]) -> dict[str, Any]:
    """Return the residual spectra of each torque record for each hypothesis, in order.

    Lines at orders of the step rate and the density between them are added by power, over all rates of a record. A fit
    without stored residuals has null.

    Returns
    -------
    dict
        ``unit``, ``centres_hz`` (B), and ``records``: name, ``rms`` (hypotheses x B), ``noise`` (B), null where
        unknown.
    """
    from mechid.analysis.residual_emission import CENTRES_HZ

    found = [_residuals(hypothesis) for hypothesis in hypotheses]
    names = dict.fromkeys(name for own in found for name in own)
    return {
        "unit": "N m",
        "centres_hz": CENTRES_HZ.tolist(),
        "records": [_record(name, [own.get(name) for own in found], CENTRES_HZ) for name in names],
    }


def band_rms(record: ResidualRecord, centres: FloatArray) -> FloatArray:
    """Return the residual RMS of a record in each third octave, (B,) N m; NaN where no window resolves it."""
    power, weight = np.zeros((2, centres.size))
    for at in record.rates:
        own = _power(at, centres)
        known = np.isfinite(own)
        power[known] += at.duration_s * own[known]
        weight[known] += at.duration_s
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sqrt(power / weight), dtype=np.float64)


def _power(at: ResidualAtRate, centres: FloatArray) -> FloatArray:
    """Return the power at one rate in each third octave, (B,) (N m)^2."""
    power = at.density * WIDTH * centres
    # Without their noise, which the density includes already.
    lines = np.maximum(at.amplitude**2 - at.sigma**2, 0.0) / 2.0
    bands = np.rint(THIRDS_A_DECADE * np.log10(at.rate * at.orders)).astype(np.int64)
    is_drawn = np.isfinite(lines) & (bands >= 0) & (bands < centres.size)
    np.add.at(power, bands[is_drawn], lines[is_drawn])
    return np.asarray(power, dtype=np.float64)


def _residuals(hypothesis: Hypothesis) -> dict[str, ResidualRecord]:
    """Return the residuals of a fit by record; empty if they are not stored or damaged."""
    try:
        records = hypothesis.residuals.torques if hypothesis.residuals else None
    except InputFileError:
        # A comparison needs them only for a figure.
        return {}
    return {record.name: record for record in records or ()}


def _record(name: str, each: Sequence[ResidualRecord | None], centres: FloatArray) -> dict[str, Any]:
    rms = [None if record is None else band_rms(record, centres) for record in each]
    first = next(record for record in each if record is not None)
    known = np.any([np.isfinite(own) for own in rms if own is not None], axis=0)
    noise = np.where(known, np.sqrt(first.noise_density * WIDTH * centres), np.nan)
    return {"name": name, "rms": [None if own is None else _numbers(own) for own in rms], "noise": _numbers(noise)}


def _numbers(values: FloatArray) -> list[float | None]:
    return [float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None for value in values]
