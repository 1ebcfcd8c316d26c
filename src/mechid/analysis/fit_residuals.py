"""Residuals of a fit: how it predicts each record, what is left of their torques, what was measured beside them."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

from mechid.analysis.order_tracking import OrderError
from mechid.errors import InputFileError
from mechid.reading.whole import read_result

if TYPE_CHECKING:
    from mechid.analysis.components_file import SideRecords
    from mechid.analysis.residual_file import ResidualRecord
    from mechid.analysis.validation import Validations
    from mechid.identification.result.fit import Fit

REPORT_NAME = "report.json"


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
    """Prediction of one record, as estimate.json keeps it in the table ``validation``.

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


@dataclass(frozen=True, eq=False)
class FitResiduals:
    """Residuals of one fit, from its folder or computed.

    identify leaves them in estimate.json, residual.json and components.json. Each file is read when it is first asked
    for. Of a fit in memory, and where the folder holds none, they are computed from the campaign that the fit holds;
    both ways give the same numbers.
    """

    fit: Fit

    @cached_property
    def summaries(self) -> Mapping[str, ValidationSummary]:
        """How each record is predicted, by name; empty where the folder does not say.

        Raises
        ------
        InputFileError
            The estimate is damaged.
        UsageError
            The fit has neither a folder nor its campaign.
        """
        found = _read_summaries(self.fit)
        if found or (self.fit.folder and self.fit.campaign is None):
            return found
        return {name: ValidationSummary.from_dict(record.to_dict()) for name, record in self._validation.items()}

    @cached_property
    def torques(self) -> tuple[ResidualRecord, ...] | None:
        """What is left of each torque record over the rate; None where the folder does not say.

        Raises
        ------
        InputFileError
            residual.json is damaged, or of another fit.
        UsageError
            The fit has neither a folder nor its campaign.
        """
        from mechid.analysis.residual_file import residual_records

        return residual_records(self.fit, self._validation) if self._is_computed else self._torques_left

    @cached_property
    def components(self) -> SideRecords | None:
        """Forces and moments measured beside the torques; None where there are none.

        Raises
        ------
        InputFileError
            components.json is damaged, or of another fit.
        UsageError
            The fit has neither a folder nor its campaign.
        """
        from mechid.analysis.components_file import read_components, side_records

        return side_records(self.fit, self._validation) if self._is_computed else read_components(self.fit)

    @cached_property
    def _is_computed(self) -> bool:
        """Whether the folder lacks residual.json, which identify always leaves, and the campaign is at hand."""
        return self.fit.folder is None or (self.fit.campaign is not None and self._torques_left is None)

    @cached_property
    def _torques_left(self) -> tuple[ResidualRecord, ...] | None:
        from mechid.analysis.residual_file import read_residual  # a comparison reads no such file

        return read_residual(self.fit)

    @cached_property
    def _validation(self) -> Validations:
        from mechid.analysis.validation import validate  # the simulator, which a fit in a folder does not need

        return validate(self.fit.required_campaign, self.fit)


def _read_summaries(fit: Fit) -> dict[str, ValidationSummary]:
    """Return the ``validation`` table of each record whose estimate.json has one."""
    tables = {name: record.validation for name, record in fit.records.items() if record.validation is not None}
    try:
        return {name: ValidationSummary.from_dict(table) for name, table in tables.items()}
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        what = f"no {error}" if isinstance(error, KeyError) else "an entry is not what this mechid writes"
        raise InputFileError(f"{fit.source}: {what}; it was written by another version, identify anew") from error


def is_simulated(fit: Fit) -> bool:
    """Whether the records of a fit were simulated, as it says itself or the report in its folder does."""
    if fit.synthetic or fit.folder is None:
        return fit.synthetic
    try:
        report = json.loads(read_result(fit.folder / REPORT_NAME))
    except (OSError, ValueError):
        return False
    is_of_fit = isinstance(report, dict) and report.get("provenance") == fit.provenance
    return is_of_fit and bool(report.get("synthetic"))


def _number(value: float | None) -> float:
    """Return a number, NaN for the null that estimate.json has in its place."""
    return math.nan if value is None else float(value)
