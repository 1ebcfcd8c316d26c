"""Residuals of a fit: prediction quality, residual torques and further measured components of each record."""

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
    """Prediction of one channel, with attributes as in `ChannelValidation`; NaN if the simulation failed."""

    samples: int
    samples_sha256: str
    effective_samples: float
    residual_rms: float
    fit_percent: float
    orders: tuple[OrderError, ...]

    @classmethod
    def from_dict(cls, own: Mapping[str, Any]) -> Self:
        """Read the summary from a channel's entry in the ``validation`` table."""
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
    """Prediction of one record, as stored in the table ``validation`` of estimate.json.

    Attributes
    ----------
    command : mapping
        Stepping assumed for the driver.
    judged_from_s : float or None
        Record time from which a held-out record is evaluated; its per-record parameters are fitted before that.
    channels : mapping of quantity to ChannelSummary
        The leading one first.
    """

    command: Mapping[str, str | int | float]
    judged_from_s: float | None
    channels: Mapping[str, ChannelSummary]

    @classmethod
    def from_dict(cls, own: Mapping[str, Any]) -> Self:
        """Read the summary from a record's ``validation`` table, as made by `RecordValidation.to_dict`."""
        return cls(
            command=own["command"],
            judged_from_s=own["judged_from_s"],
            channels={quantity: ChannelSummary.from_dict(channel) for quantity, channel in own["channels"].items()},
        )


@dataclass(frozen=True, eq=False)
class FitResiduals:
    """Residuals of one fit, read from its folder or computed.

    ``mechid identify`` stores them in estimate.json, residual.json and components.json. Each file is read on first
    use. For a fit in memory, or if the folder lacks the files, they are computed from the campaign of the fit. Both
    ways give the same numbers.
    """

    fit: Fit

    @cached_property
    def summaries(self) -> Mapping[str, ValidationSummary]:
        """Prediction of each record, by name; empty if the folder does not contain it.

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
        """Residual torque of each record over the rate; None if the folder does not contain it.

        Raises
        ------
        InputFileError
            residual.json is damaged or belongs to another fit.
        UsageError
            The fit has neither a folder nor its campaign.
        """
        from mechid.analysis.residual_file import residual_records

        return residual_records(self.fit, self._validation) if self._is_computed else self._stored_torques

    @cached_property
    def components(self) -> SideRecords | None:
        """Forces and moments measured besides the torque; None if there are none.

        Raises
        ------
        InputFileError
            components.json is damaged or belongs to another fit.
        UsageError
            The fit has neither a folder nor its campaign.
        """
        from mechid.analysis.components_file import read_components, side_records

        return side_records(self.fit, self._validation) if self._is_computed else read_components(self.fit)

    @cached_property
    def _is_computed(self) -> bool:
        """Whether to compute the residuals: the folder lacks residual.json, and the campaign is available."""
        return self.fit.folder is None or (self.fit.campaign is not None and self._stored_torques is None)

    @cached_property
    def _stored_torques(self) -> tuple[ResidualRecord, ...] | None:
        # Imported here: a comparison does not read residual.json.
        from mechid.analysis.residual_file import read_residual

        return read_residual(self.fit)

    @cached_property
    def _validation(self) -> Validations:
        # Imported here: it loads the simulator, which a fit in a folder does not need.
        from mechid.analysis.validation import validate

        return validate(self.fit.required_campaign, self.fit)


def _read_summaries(fit: Fit) -> dict[str, ValidationSummary]:
    """Read the ``validation`` tables of a fit, by record."""
    tables = {name: record.validation for name, record in fit.records.items() if record.validation is not None}
    try:
        return {name: ValidationSummary.from_dict(table) for name, table in tables.items()}
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        problem = f"no {error}" if isinstance(error, KeyError) else "an entry is not what this mechid writes"
        raise InputFileError(f"{fit.source}: {problem}; it was written by another version, identify anew") from error


def is_simulated(fit: Fit) -> bool:
    """Return whether the records were simulated, according to the fit or the report in its folder."""
    if fit.synthetic or fit.folder is None:
        return fit.synthetic
    try:
        report = json.loads(read_result(fit.folder / REPORT_NAME))
    except (OSError, ValueError):
        return False
    is_of_fit = isinstance(report, dict) and report.get("provenance") == fit.provenance
    return is_of_fit and bool(report.get("synthetic"))


def _number(value: float | None) -> float:
    """Return a number, NaN for null in estimate.json."""
    return math.nan if value is None else float(value)
