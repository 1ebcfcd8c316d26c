"""Predicted verdicts at every rate as a table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

TEXTS = ("requirement", "direction", "kind", "unit", "stepping", "verdict")
NUMBERS = {
    "frequency_Hz": "frequency_Hz",
    "value": "value",
    "sigma": "sigma",
    "limit": "limit",
    "lower": "lower",
    "upper": "upper",
    "margin_dB": "margin_dB",
}
"""Columns of the value that decides at a rate, each with its key in the numbers."""
FLAGS = ("outside", "follows")
HEADER = (*TEXTS, "rate_steps_per_s", *NUMBERS, *FLAGS)


def predicted_rows(requirement: Mapping[str, Any], predicted: Mapping[str, Any]) -> Iterator[list[Any]]:
    """Yield a row of the columns of `HEADER` for each rate; numbers are None where nothing was judged."""
    for at in predicted["at_rates"]:
        worst = at["worst"] or {}
        words = [requirement[key] for key in ("name", "direction", "kind", "unit")]
        numbers = [worst.get(key) for key in NUMBERS.values()]
        yield [*words, at["stepping"], at["verdict"], at["rate"], *numbers, *(int(at[flag]) for flag in FLAGS)]
