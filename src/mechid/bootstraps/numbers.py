"""Numbers of a bootstrap in one dict, and their files."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mechid.identification.refit.bootstrap import Bootstrap, DrawOutcome, Spread
from mechid.identification.result.estimate_file import json_text, provenance_of_fits
from mechid.ink.digits import digits, like, with_sigma
from mechid.signal.autoregression import Autoregression

FORMAT = "mechid-bootstrap/1"
FILE_NAME, DRAWS_NAME = "bootstrap.json", "bootstrap.csv"


def bootstrap_numbers(found: Bootstrap, seed: int) -> dict[str, Any]:
    """Return the numbers shown for a bootstrap, with formatted texts."""
    return {
        "format": FORMAT,
        "synthetic": found.synthetic,
        "seed": seed,
        "draws": len(found.draws),
        "tally": {outcome.code: count for outcome, count in found.tally.items()},
        "noise": {name: _noise(own) for name, own in found.noise.items()},
        "parameters": {s.name: _spread(s) for s in found.spreads},
        "refits": [{"draw": d.number, "outcome": d.outcome.code, "cost": d.cost, **d.values} for d in found.draws],
        "warnings": [
            f"{count} of {len(found.draws)} refits {outcome.value}"
            for outcome, count in found.tally.items()
            if count and outcome is not DrawOutcome.CONVERGED
        ],
        "provenance": provenance_of_fits(found.fit_digest),
    }


def bootstrap_texts(data: Mapping[str, Any]) -> dict[str, str]:
    """Return bootstrap.json, and bootstrap.csv with one line per draw."""
    names = list(data["refits"][0])
    rows = [",".join(names)] + [",".join(str(refit[name]) for name in names) for refit in data["refits"]]
    return {FILE_NAME: json_text(data), DRAWS_NAME: "\n".join(rows) + "\n"}


def _spread(s: Spread) -> dict[str, Any]:
    value, error = with_sigma(s.value, s.std_error or s.deviation)
    return {
        "unit": s.unit,
        "value": s.value,
        "std_error": s.std_error,
        "deviation": s.deviation,
        "mean_shift": s.mean_shift,
        "ci95": list(s.interval),
        "text": {
            "estimate": value,
            "std_error": error if s.std_error else "",
            "deviation": digits(s.deviation, 2),
            "mean_shift": digits(s.mean_shift, 2),
            "low": like(s.interval[0], s.deviation),
            "high": like(s.interval[1], s.deviation),
            "unit": "" if s.unit == "1" else s.unit,
        },
    }


def _noise(own: Mapping[str, Autoregression]) -> dict[str, Any]:
    """Return the noise model of a record by channel."""
    return {quantity: {"order": model.order, "sigma": model.sigma} for quantity, model in own.items()}
