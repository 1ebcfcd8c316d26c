"""Validation of a fit on each record, fitted or held out."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, TypeAlias

import numpy as np

from mechid.analysis.order_tracking import OrderError, order_errors
from mechid.analysis.prediction import Prediction, predict
from mechid.analysis.residual_emission import ResidualAtRate, residual_emission
from mechid.analysis.side_components import SideAtRate, side_components
from mechid.arrays import FloatArray
from mechid.campaign import Campaign, CampaignRecord
from mechid.command import Command
from mechid.display import DisplayedResult
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.result.finished_fit import record_as_fitted
from mechid.identification.result.fit import Fit
from mechid.identification.result.record_result import Nuisance
from mechid.plant.mechanism import NamedLine
from mechid.records import COMPONENTS, Mounting
from mechid.signal import (
    Band,
    LjungBox,
    TheilInequality,
    effective_samples,
    fit_percent,
    ljung_box,
    power_density,
    theil_inequality,
    third_octaves,
)
from mechid.signal.remainder import Remainder
from mechid.signal.series import Series, blocks, stretch_of
from mechid.signal.trend import fit_line
from mechid.units import SI_UNIT

TORQUE = "torque"
Listener: TypeAlias = "Callable[[RecordValidation, Mapping[str, Prediction]], None]"


def _ignore(validation: RecordValidation, predictions: Mapping[str, Prediction]) -> None:
    """Ignore the validation; the default listener."""


@dataclass(frozen=True, kw_only=True)
class BandError:
    """RMS of the measured channel and its residual in a third-octave band, in the unit of the channel."""

    centre_hz: float
    measured_rms: float
    residual_rms: float


@dataclass(frozen=True, kw_only=True, eq=False)
class ChannelValidation:
    """Validation of one channel, without offset and drift.

    It covers the whole record. If per-record parameters of a held-out record were fitted on its first part, only the
    rest is evaluated.

    Attributes
    ----------
    quantity, unit : str
    samples : int
    samples_sha256 : str
        Digest of all samples of the record, their rate and start; equal for equal data.
    fit_percent : float
    residual_rms : float
        In the channel's unit.
    theil : TheilInequality
        The bias is 0 if an offset is removed.
    whiteness : LjungBox
    effective_samples : float
        Effective sample count of the residual.
    spectrum_hz : (M,)
    measured_density, residual_density : (M,)
        Power density by Welch's method, unit squared per Hz.
    bands : tuple of BandError
        The same in third octaves; empty if the simulation failed.
    orders : tuple of OrderError
        Empty if the command travels less than four full steps or the simulation failed.
    emission : tuple of ResidualAtRate
        Residual torque over the rate, for the budget; empty for other channels, or as `orders`.
    use : str
        ``"validate"`` for a channel that is only compared although its record is fitted; else empty.
    """

    quantity: str
    unit: str
    samples: int
    samples_sha256: str
    fit_percent: float
    residual_rms: float
    theil: TheilInequality
    whiteness: LjungBox
    effective_samples: float
    spectrum_hz: FloatArray
    measured_density: FloatArray
    residual_density: FloatArray
    bands: tuple[BandError, ...]
    orders: tuple[OrderError, ...]
    emission: tuple[ResidualAtRate, ...] = ()
    use: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Return the entry in estimate.json: all but the fine spectra."""
        return {
            "unit": self.unit,
            "samples": self.samples,
            "samples_sha256": self.samples_sha256,
            "fit_percent": self.fit_percent,
            "residual_rms": self.residual_rms,
            "theil": asdict(self.theil),
            "ljung_box": asdict(self.whiteness),
            "effective_samples": self.effective_samples,
            "bands": [asdict(band) for band in self.bands],
            "orders": [asdict(order) for order in self.orders],
        }


@dataclass(frozen=True, kw_only=True)
class RecordValidation:
    """Validation of a record: assumed stepping, and channels by quantity.

    `side` are the lines over the rate of the `components` besides the drive torque, about the mounting point; empty if
    there are none. `nuisance` are per-record parameters of a held-out record, fitted on its first part; only the rest
    is evaluated.
    """

    name: str
    use: str
    command: Mapping[str, str | int | float]
    channels: Mapping[str, ChannelValidation]
    components: tuple[str, ...] = ()
    side: tuple[SideAtRate, ...] = ()
    mounting: Mounting | None = None
    nuisance: Nuisance | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the record's ``validation`` table in estimate.json."""
        channels = {quantity: channel.to_dict() for quantity, channel in self.channels.items()}
        judged_from_s = self.nuisance.until_s if self.nuisance else None
        return {"command": dict(self.command), "judged_from_s": judged_from_s, "channels": channels}


class Validations(DisplayedResult, dict[str, RecordValidation]):
    """Validation of each record, by name; shown in a notebook as the table of the report."""

    __repr__ = DisplayedResult.__repr__


def validate(campaign: Campaign, fit: Fit, listener: Listener = _ignore) -> Validations:
    """Predict each record of a campaign with a fit, without refitting, and evaluate the residual.

    The whole record is evaluated, even if a stage fitted only a window of it. If per-record parameters of a held-out
    record were fitted on its first part, only the rest is evaluated. If a simulation fails, the results are NaN.

    Parameters
    ----------
    campaign : Campaign
        The campaign of the fit, with its records read.
    fit : Fit
    listener : callable
        Called for each record with its validation and its predictions by quantity, as soon as they are available.

    Returns
    -------
    Validations
        A dict of str to RecordValidation: by name, in the order of the campaign.

    Examples
    --------
    >>> import mechid
    >>> campaign = mechid.load_campaign("bench")  # doctest: +SKIP
    >>> held_out = mechid.validate(campaign, mechid.identify(campaign))["sweep"]  # doctest: +SKIP
    >>> held_out.channels["torque"].theil.coefficient  # doctest: +SKIP
    """
    found = Validations()
    # A failed simulation leaves NaN, which needs no warnings.
    with one_core_algebra(), np.errstate(all="ignore"):
        for record in campaign.records:
            if record.data is not None:
                predicted = predict(record, fit)
                found[record.name] = _validate_record(record, campaign, fit, predicted)
                listener(found[record.name], predicted)
    return found


def _validate_record(
    record: CampaignRecord, campaign: Campaign, fit: Fit, predicted: Mapping[str, Prediction]
) -> RecordValidation:
    fitted = record_as_fitted(record, fit)
    components = _components(fitted) if TORQUE in predicted else ()
    return RecordValidation(
        name=record.name,
        use=fitted.use,
        command=_driver_assumptions(fitted.command),
        channels={
            q: replace(
                channel_validation(q, SI_UNIT[q], p, fit.mains_hz, fit.mechanism.named_lines),
                use=_only_compared(record, q),
            )
            for q, p in predicted.items()
        },
        components=components,
        side=_side(fitted, components, predicted[TORQUE], fit.mains_hz) if components else (),
        mounting=campaign.mounting if components else None,
        nuisance=fit.records[record.name].nuisance if record.name in fit.records else None,
    )


def _components(record: CampaignRecord) -> tuple[str, ...]:
    """Return the components measured besides the drive torque, in a fixed order independent of the columns."""
    held = {channel.quantity for channel in record.data.channels} if record.data else set()
    return tuple(component for component in COMPONENTS if component in held)


def _side(
    record: CampaignRecord, components: Sequence[str], torque: Prediction, mains_hz: float | None
) -> tuple[SideAtRate, ...]:
    """Compute the lines of the components, with phases relative to the torque as interpreted by the fit."""
    assert record.data is not None
    level: list[Series] = [torque.evaluated_part.level]
    for quantity in components:
        data = stretch_of(record.data.channel(quantity).data, torque.evaluated_from, torque.base.samples)
        level.append(Remainder(data, fit_line(data, 2)))
    return side_components(level, torque.evaluated_part.travel, torque.base.sample_rate_hz, mains_hz)


def _only_compared(record: CampaignRecord, quantity: str) -> str:
    """Return ``"validate"`` for a channel that is not fitted, else an empty string."""
    return "" if any(match.quantity == quantity for match in record.estimated) else "validate"


def with_validation(content: Mapping[str, Any], validation: Mapping[str, RecordValidation]) -> dict[str, Any]:
    """Add a ``validation`` table to each record in the content of estimate.json."""
    own = {name: {"validation": v.to_dict()} for name, v in validation.items()}
    records = {name: {**record, **own.get(name, {})} for name, record in content["records"].items()}
    return {**content, "records": records}


def channel_validation(
    quantity: str, unit: str, p: Prediction, mains_hz: float | None = None, named: Sequence[NamedLine] = ()
) -> ChannelValidation:
    """Validate one predicted channel; hum at multiples of `mains_hz` does not count as emission.

    `named` are the lines that the mechanism names, which are tracked in the residual of the torque.
    """
    samples = _digest(p)
    p = p.evaluated_part
    measured, r = p.level, p.residual
    # Only the torque acts on the structure; other channels are not emission.
    counted, emits = r.size - p.rejected.size, p.finite and quantity == TORQUE
    frequency, measured_density = power_density(p.measured, p.base.sample_rate_hz)
    residual_density = power_density(r, p.base.sample_rate_hz)[1]
    return ChannelValidation(
        quantity=quantity,
        unit=unit,
        samples=r.size,
        samples_sha256=samples,
        fit_percent=fit_percent(measured, r, p.rejected) if p.finite else math.nan,
        residual_rms=math.sqrt(sum(float(np.sum(r[part] ** 2)) for part in blocks(r.size)) / counted),
        theil=theil_inequality(measured, p.modelled, p.rejected),
        whiteness=ljung_box(r, rejected=p.rejected),
        effective_samples=effective_samples(r) * (1.0 - p.rejected.size / r.size),
        spectrum_hz=frequency,
        measured_density=measured_density,
        residual_density=residual_density,
        bands=_bands(frequency, measured_density, residual_density) if p.finite else (),
        orders=order_errors(measured, p.modelled, p.travel, p.base.sample_rate_hz) if p.finite else (),
        emission=residual_emission(r, p.travel, p.base.sample_rate_hz, mains_hz, named) if emits else (),
    )


def _driver_assumptions(command: Command) -> dict[str, str | int | float]:
    """Return the assumptions of a command on the driver, without its rate."""
    return {
        "stepping": command.stepping,
        "microsteps": command.microsteps,
        "start_angle_deg": command.start_angle_deg,
        "waveform": command.waveform_name,
        "start": command.start,
    }


def _bands(frequency: FloatArray, measured: FloatArray, residual: FloatArray) -> tuple[BandError, ...]:
    pairs: zip[tuple[Band, Band]] = zip(
        third_octaves(frequency, measured), third_octaves(frequency, residual), strict=True
    )
    return tuple(BandError(centre_hz=m.centre_hz, measured_rms=m.rms, residual_rms=r.rms) for m, r in pairs)


def _digest(p: Prediction) -> str:
    # Little-endian bytes, so that the digest is the same on any machine.
    digest = hashlib.sha256(f"{p.base.sample_rate_hz!r} {p.base.start_s!r}".encode())
    for part in blocks(p.measured.size):
        digest.update(np.asarray(p.measured[part], dtype="<f8").tobytes())
    return digest.hexdigest()
