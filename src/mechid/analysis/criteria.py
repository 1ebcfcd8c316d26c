"""Information criteria of hypotheses: likelihood against the number of parameters.

The likelihood is Gaussian with each record's own noise level at its maximum, the residual's RMS s:
-2 ln L = sum over records of n (ln(2 pi s^2) + 1). Coloured residuals carry less information than their
sample count n suggests, so the criteria are also computed with effective sample counts. These are taken from
the hypothesis with the smallest residual, which is closest to pure noise, and used for all hypotheses, since
likelihoods are comparable only over the same data.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from mechid.analysis.hypothesis import Hypothesis, RecordEvidence


@dataclass(frozen=True, kw_only=True)
class Score:
    """Criteria of a hypothesis; lower is better, and only differences between hypotheses are meaningful.

    Attributes
    ----------
    hypothesis : str
    free : int
        Number of estimated parameters of the mechanism and the records.
    fitted_count : int
        k: these parameters, fitted offsets and drifts, and one noise level per record.
    samples, effective_samples : float
        Sample counts of the fitted records.
    deviance : float
        -2 ln L over all samples.
    aic, bic : float
        deviance + 2 k, deviance + k ln n, assuming white residuals.
    aic_effective, bic_effective : float
        The same with effective samples; infinite if a simulation fails.
    held_out : float
        sum of n_eff ln s^2 over the validation records.
    """

    hypothesis: str
    free: int
    fitted_count: int
    samples: float
    effective_samples: float
    deviance: float
    aic: float
    bic: float
    aic_effective: float
    bic_effective: float
    held_out: float


def shared_effective_samples(hypotheses: Sequence[Hypothesis]) -> dict[str, float]:
    """Return the effective sample count of the smallest residual of each record; NaN if all simulations failed."""
    return {name: _of_smallest([h.records[name] for h in hypotheses]) for name in hypotheses[0].records}


def _of_smallest(records: Sequence[RecordEvidence]) -> float:
    followed = [r for r in records if math.isfinite(r.residual_rms)]
    return min(followed, key=lambda r: r.residual_rms).effective_samples if followed else math.nan


def score(hypothesis: Hypothesis, effective: Mapping[str, float]) -> Score:
    """Compute the criteria of a hypothesis from the records' effective sample counts."""
    used, k = hypothesis.used_for("estimate"), hypothesis.fitted_count
    n, m = float(sum(r.samples for r in used)), sum(effective[r.name] for r in used)
    by_all = sum(_deviance(r, r.samples) for r in used)
    by_effective = sum(_deviance(r, effective[r.name]) for r in used)
    return Score(
        hypothesis=hypothesis.name,
        free=len(hypothesis.free),
        fitted_count=k,
        samples=n,
        effective_samples=m,
        deviance=by_all,
        aic=by_all + 2.0 * k,
        bic=by_all + k * math.log(n),
        aic_effective=by_effective + 2.0 * k,
        bic_effective=by_effective + k * math.log(m) if math.isfinite(by_effective) else math.inf,
        held_out=sum(_deviance(r, effective[r.name]) for r in hypothesis.used_for("validate")),
    )


def _deviance(record: RecordEvidence, samples: float) -> float:
    """Return -2 ln L of a record at its own noise level; infinite if the simulation failed."""
    s = record.residual_rms
    followed = s > 0.0 and math.isfinite(s) and math.isfinite(samples)
    return samples * (math.log(2.0 * math.pi * s**2) + 1.0) if followed else math.inf
