"""Hypotheses side by side: every number in one dict, and its ink for a terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console

from mechid.analysis.comparison import Comparison, ParameterComparison, RecordComparison
from mechid.analysis.criteria import Score
from mechid.analysis.hypothesis import Hypothesis
from mechid.identification.result.estimate_file import json_text
from mechid.ink.console import print_lines, say, say_if_synthetic
from mechid.ink.digits import digits, rounded, with_sigma
from mechid.ink.text_table import Column, print_tables
from mechid.writing import write_together

FORMAT = "mechid-comparison/1"
FILE_NAME = "comparison.json"
HYPOTHESIS = Column("hypothesis", "name", words=True)
FITTED = (Column("free", "free"), Column("fitted", "counted"))
EFFECTIVE = (
    Column("AIC", "aic_effective"),
    Column("BIC", "bic_effective"),
    Column("AIC white", "aic"),
    Column("BIC white", "bic"),
)
SCORE_LAYOUTS = (
    ((HYPOTHESIS, *FITTED, *EFFECTIVE, Column("grade", "grade", words=True)),),
    ((HYPOTHESIS, *FITTED, *EFFECTIVE), (HYPOTHESIS, Column("grade", "grade", words=True))),
)
NO_SUCH = "."


def comparison_data(comparison: Comparison) -> dict[str, Any]:
    """Return all that a comparison shows: numbers, and beside those that need rounding their text."""
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
    }


def write_comparison(data: Mapping[str, Any], folder: Path | str) -> Path:
    """Write comparison.json into a folder, made where it is missing, and return its path.

    Raises
    ------
    UsageError
        The folder cannot be written to.
    """
    return write_together(folder, {FILE_NAME: json_text(data)})[0]


def print_comparison(data: Mapping[str, Any], console: Console, files: Sequence[Path] = ()) -> None:
    """Print what `comparison_data` made, and where the file is."""
    say_if_synthetic(console, data)
    preferred = f" Preferred: {data['preferred']}." if data["preferred"] else ""
    say(console, data["outcome"]["message"] + preferred, "bold")
    print_lines(console, "because", data["grounds"])
    print_lines(console, "caution", data["cautions"], "yellow")
    console.print()
    say(console, "Criteria above the least; by effective samples, and as if residuals were white", "bold")
    print_tables(console, SCORE_LAYOUTS, data["scores"])
    names = data["hypotheses"]
    say(console, "Records; residual RMS in N m", "bold")
    print_tables(console, _record_layouts(names), data["records"])
    say(console, f"Parameters; off: difference to {names[0]}, in sigmas", "bold")
    print_tables(console, _parameter_layouts(names), data["parameters"])
    print_lines(console, "written", [str(path) for path in files])


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
            "counted": str(score.counted),
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
        "text": {"samples": str(record.samples), "effective": rounded(record.effective_samples), **texts},
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


def _record_layouts(names: Sequence[str]) -> tuple[tuple[tuple[Column, ...], ...], ...]:
    first = (Column("record", "name", words=True), Column("use", "use", words=True))
    size = (Column("samples", "samples"), Column("effective", "effective"))
    residuals = tuple(Column(name, f"residual_{i}") for i, name in enumerate(names))
    fits = tuple(Column(f"{name} fit %", f"fit_{i}") for i, name in enumerate(names))
    return ((first + size + residuals + fits,), (first + size, first[:1] + residuals, first[:1] + fits))


def _parameter_layouts(names: Sequence[str]) -> tuple[tuple[tuple[Column, ...], ...], ...]:
    first, unit = Column("parameter", "key", words=True), Column("unit", "unit", words=True)
    each = [
        (Column(name, f"value_{i}"), Column("+- sigma", f"sigma_{i}"), *([Column("off", f"off_{i}")] if i else []))
        for i, name in enumerate(names)
    ]
    return (((first, unit, *(c for columns in each for c in columns)),), tuple((first, *columns) for columns in each))
