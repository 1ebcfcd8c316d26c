"""Predicted verdict on a requirement as one plain dict."""

from __future__ import annotations

from typing import Any

from mechid.budgets.prediction import PredictedAt, Prediction
from mechid.ink.digits import plain
from mechid.specification.numbers import VERDICT_WORDS, requirement_numbers, worst_numbers, worst_texts


def prediction_numbers(prediction: Prediction) -> dict[str, Any]:
    """Return verdict, value that decides it, and the verdicts at all rates."""
    judged = prediction.judged
    return {
        "verdict": judged.verdict.value,
        "worst": worst_numbers(judged.worst),
        "judged_Hz": list(prediction.judged_hz) if prediction.judged_hz else None,
        "at_rates": [_at_rate(at) for at in prediction.at_rates],
        "notes": list(prediction.notes),
    }


def exported_numbers(prediction: Prediction) -> dict[str, Any]:
    """Return a requirement of a budget with its predicted verdict."""
    worst = prediction.judged.worst
    text = {"verdict": VERDICT_WORDS[prediction.verdict], "mode": worst.record if worst else "", **worst_texts(worst)}
    return {**requirement_numbers(prediction.requirement), **prediction_numbers(prediction), "text": text}


def _at_rate(at: PredictedAt) -> dict[str, Any]:
    return {
        "stepping": at.stepping,
        "rate": at.rate,
        "outside": at.outside,
        "follows": at.follows,
        "verdict": at.judged.verdict.value,
        "worst": worst_numbers(at.judged.worst),
        "text": {
            "verdict": VERDICT_WORDS[at.judged.verdict],
            **worst_texts(at.judged.worst),
            "rate": plain(at.rate, 5),
        },
    }
