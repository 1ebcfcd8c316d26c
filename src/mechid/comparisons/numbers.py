"""Numbers of a comparison, in one dict."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from mechid.analysis.comparison import Comparison, ParameterComparison, RecordComparison
from mechid.analysis.criteria import Score
from mechid.analysis.hypothesis import Hypothesis
from mechid.comparisons.spectra import residual_spectra
from mechid.identification.result.estimate_file import provenance_of_fits
from mechid.ink.digits import count_text, digits, with_sigma

FORMAT = "mechid-comparison/1"
FILE_NAME = "comparison.json"
NO_SUCH = "."


def comparison_numbers(comparison: Comparison) -> dict[str, Any]:
    """Return the numbers shown by a comparison, with formatted texts."""
    best = {key: _least(comparison.scores, key) for key in ("aic", "bic", "aic_effective", "bic_effective")}
    return {
        "format": FORMAT,
        "synthetic": any(h.synthetic for h in comparison.hypotheses),
        "hypotheses": [h.name for h in comparison.hypotheses],
        "outcome": {"code": comparison.preference.outcome.code, "message": comparison.preference.outcome.value},
        "preferred": comparison.preference.preferred,
        "grounds": list(comparison.preference.grounds),
        "cautions": list(comparison.cautions),
        "scores": [_score(h, s, best) for h, s in zip(comparison.hypotheses, comparison.scores, strict=True)],
        "records": [_record(r) for r in comparison.records],
        "parameters": [_parameter(p) for p in comparison.parameters],
        "spectra": residual_spectra(comparison.hypotheses),
        "provenance": provenance_of_fits(*(h.fit_digest for h in comparison.hypotheses)),
    }


def _least(scores: Sequence[Score], key: str) -> float:
    return min((v for s in scores if math.isfinite(v := getattr(s, key))), default=math.nan)


def _score(hypothesis: Hypothesis, score: Score, best: Mapping[str, float]) -> dict[str, Any]:
    return {
        "name": hypothesis.name,
        "grade": str(hypothesis.grade),
        "outcome": hypothesis.outcome.code,
        **asdict(score),
        "text": {
            "free": str(score.free),
            "counted": str(score.fitted_count),
            **{key: digits(getattr(score, key) - least, 4) for key, least in best.items()},
        },
    }


def _record(record: RecordComparison) -> dict[str, Any]:
    each = zip(record.residual_rms, record.fit_percent, strict=True)
    texts: dict[str, str] = {}
    for i, (rms, fit) in enumerate(each):
        texts |= {f"residual_{i}": digits(rms, 4), f"fit_{i}": digits(fit, 4)}
    return {
        **asdict(record),
        "text": {"samples": str(record.samples), "effective": count_text(record.effective_samples), **texts},
    }


def _parameter(p: ParameterComparison) -> dict[str, Any]:
    texts: dict[str, str] = {}
    for i, (believed, difference) in enumerate(zip(p.values, p.differences_sigmas, strict=True)):
        value, sigma = with_sigma(believed.value, believed.std_error) if believed else (NO_SUCH, "")
        status = believed.status if believed and not sigma and believed.status != "known" else ""
        texts |= {
            f"value_{i}": value,
            f"sigma_{i}": sigma or status.replace("_", " "),
            f"off_{i}": "" if difference is None else f"{difference:+.1f}",
        }
    table, _, key = p.name.rpartition(".")
    values = [asdict(v) if v else None for v in p.values]
    return {
        "name": p.name,
        "table": table,
        "key": key,
        "unit": p.unit,
        "values": values,
        "differences_sigmas": list(p.differences_sigmas),
        "text": {**texts, "unit": "" if p.unit == "1" else p.unit},
    }
