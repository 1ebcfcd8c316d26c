"""Summary of a record's validation, as estimate.json keeps it under each record."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

from mechid.analysis.order_tracking import OrderError


@dataclass(frozen=True, kw_only=True)
class ChannelSummary:
    """Prediction of one channel; the attributes are those of `ChannelValidation`, NaN where the simulation failed."""

    samples: int
    samples_sha256: str
    effective_samples: float
    residual_rms: float
    fit_percent: float
    orders: tuple[OrderError, ...]

    @classmethod
    def from_dict(cls, own: Mapping[str, Any]) -> Self:
        """Return the summary that a channel's entry of the ``validation`` table holds."""
        return cls(
            samples=own["samples"],
            samples_sha256=own["samples_sha256"],
            effective_samples=_number(own["effective_samples"]),
            residual_rms=_number(own["residual_rms"]),
            fit_percent=_number(own["fit_percent"]),
            orders=tuple(OrderError(**order) for order in own["orders"]),
        )


@dataclass(frozen=True, kw_only=True)
class ValidationSummary:
    """Prediction of one record.

    Attributes
    ----------
    command : mapping
        How the driver was taken to step.
    judged_from_s : float or None
        Record time from which on a held-out record is judged, behind the part on which its own values were fitted.
    channels : mapping of quantity to ChannelSummary
        The leading one first.
    """

    command: Mapping[str, str | int | float]
    judged_from_s: float | None
    channels: Mapping[str, ChannelSummary]

    @classmethod
    def from_dict(cls, own: Mapping[str, Any]) -> Self:
        """Return the summary that a record's ``validation`` table holds, as `RecordValidation.to_dict` makes it."""
        return cls(
            command=own["command"],
            judged_from_s=own["judged_from_s"],
            channels={quantity: ChannelSummary.from_dict(channel) for quantity, channel in own["channels"].items()},
        )


def _number(value: float | None) -> float:
    """Return a number, NaN for the null that estimate.json has in its place."""
    return math.nan if value is None else float(value)
