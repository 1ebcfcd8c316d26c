"""Words that compare a residual with the noise of its record, used wherever it is shown."""

from __future__ import annotations

import math

from mechid.analysis.noise_floor_test import NoiseComparison, NoiseLevel
from mechid.identification.output_error.noise_level import NoiseSource
from mechid.identification.uncertainty.settings import NOISE
from mechid.ink.data import Data
from mechid.ink.digits import count_text, digits, plain

DIGITS = (3, 4, 5, 6)
"""Numbers of digits to try, until a ratio differs from the largest ratio by chance."""


def compare_with_noise(data: Data, row: Data) -> NoiseComparison:
    """Compare the residual of a validated channel with the noise level known before the fit.

    A level derived from the residual itself would not test it.

    Parameters
    ----------
    data : mapping
        As `report_data` makes it.
    row : mapping
        One of its ``validation``.
    """
    rows = [r for r in (*data["channels"], *data["records"]) if r["name"] == row["name"]]
    noise = next((r["noise_known"] for r in rows if r.get("quantity", row["quantity"]) == row["quantity"]), math.nan)
    return NoiseComparison(
        residual_rms=_number(row["residual_rms"]),
        noise_sigma=_number(noise),
        samples=row["samples"],
        effective_samples=_number(row["effective_samples"]),
        floor_samples=row["samples"],
    )


def raised_words(fit: Data) -> str:
    """Return a sentence if the fit inflated the noise level of a channel, else an empty text.

    Examples
    --------
    >>> raised_words({"noise_rests_on": "residual", "text": {"noise_sigma": "0.00245"}})
    'The search raised the noise level to follow the record; it ended at 0.00245.'
    >>> raised_words({"noise_rests_on": "high-frequency floor"})
    ''
    """
    if fit["noise_rests_on"] != NoiseSource.RESIDUAL:
        return ""
    return f"The search raised the noise level to follow the record; it ended at {fit['text']['noise_sigma']}."


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def level_words(residual: NoiseComparison, *, complete: bool = False) -> str:
    """Return a sentence that compares a residual with the noise; `complete` states that the model explains all.

    Examples
    --------
    >>> record = {"noise_sigma": 1.0, "samples": 10_001, "floor_samples": 10_001}
    >>> level_words(NoiseComparison(residual_rms=1.02, effective_samples=9950.0, **record), complete=True)
    'Explained down to the noise.'
    >>> level_words(NoiseComparison(residual_rms=1.02, effective_samples=9950.0, **record))
    'No larger than the noise.'
    >>> level_words(NoiseComparison(residual_rms=1.16, effective_samples=9950.0, **record))
    '1.16 times the noise floor, where chance explains up to 1.07 with 9950 effective samples.'
    """
    if residual.level is NoiseLevel.LOST:
        return "The simulation does not come to its end."
    if residual.level is NoiseLevel.NOISE:
        return "Explained down to the noise." if complete else "No larger than the noise."
    return f"{above_words(residual)}."


def above_words(residual: NoiseComparison) -> str:
    """Return the ratio of a residual to the noise floor, and the largest ratio expected by chance.

    Examples
    --------
    >>> record = {"noise_sigma": 1.0, "samples": 10_001, "floor_samples": 10_001}
    >>> above_words(NoiseComparison(residual_rms=1.16, effective_samples=31.0, **record))
    '1.16 times the noise floor, and coloured: 10001 samples worth 31 effective ones, by chance up to 1.2'
    """
    most, effective = residual.most_by_chance, count_text(residual.effective_samples)
    # With fewer digits, the ratio could read as equal to the bound that it exceeds.
    count = next((n for n in DIGITS if digits(residual.ratio, n) != digits(most, n)), DIGITS[-1])
    times = f"{digits(residual.ratio, count)} times the noise floor"
    if residual.ratio > NOISE.misfit:
        return times  # of any number of samples
    if residual.level is NoiseLevel.COLOURED:
        samples = f"{residual.samples} samples worth {effective} effective ones"
        return f"{times}, and coloured: {samples}, by chance up to {plain(most, count)}"
    return f"{times}, where chance explains up to {plain(most, count)} with {effective} effective samples"
