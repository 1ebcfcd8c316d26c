"""Residuals of the mechanism as the user wrote it, beside the one that a fit has added terms to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self


@dataclass(frozen=True, kw_only=True)
class AsWritten:
    """How the mechanism as written predicts the records, at the values of the fit that has further terms.

    Attributes
    ----------
    follows : bool
        Whether it follows all records that were fitted to their ends.
    residual_over_noise : mapping of record to float
        RMS of the residual over the noise known before the fit, of the leading channel.
    """

    follows: bool
    residual_over_noise: Mapping[str, float]

    def to_dict(self) -> dict[str, object]:
        """Return the entry of estimate.json."""
        return {"follows": self.follows, "residual_over_noise": dict(self.residual_over_noise)}

    @classmethod
    def from_dict(cls, entry: Mapping[str, Any]) -> Self:
        """Return what an entry of estimate.json says; null stands for a ratio that is no number."""
        ratios = {name: float("nan") if r is None else float(r) for name, r in entry["residual_over_noise"].items()}
        return cls(follows=bool(entry["follows"]), residual_over_noise=ratios)
