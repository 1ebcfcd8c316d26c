"""Reading of a record: its drive and wiring, as the campaign file declares them or as reinterpreted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

from mechid.campaign import Campaign, CampaignRecord
from mechid.command import Command, RateProfile
from mechid.command.stepping import Stepping
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.parameter import Parameter, Status
from mechid.signal.series import Series
from mechid.signal.stored_series import map_samples
from mechid.simulation.simulator import excitation_over

PLAIN = ("stepping", "microsteps", "swapped")
"""Fields of `Reading` about the command that estimate.json contains unchanged."""


@dataclass(frozen=True, kw_only=True)
class Reading:
    """Differences between a record's reading and its declaration; none by default.

    Attributes
    ----------
    polarity : int
        -1 if the leading channel, the torque if there is one, has the other sign.
    direction : int
        -1 if the commanded rate has the other sign.
    start_angle_deg : float or None
        Electrical start angle in degrees.
    rate : RateProfile or None
        Commanded rate, before `direction` is applied.
    stepping : str or None
        Stepping mode, together with `microsteps`, the steps per full step.
    swapped : str or None
        Name of the record whose command it has, in exchange for its own.
    scale : float
        Factor on the samples of the leading channel.
    time_offset_s : (float, float, float) or None
        Value, lower and upper bound of a time offset to be estimated, s.
    left_out : bool
        Whether the record is excluded from the fit.
    """

    polarity: int = 1
    direction: int = 1
    start_angle_deg: float | None = None
    rate: RateProfile | None = None
    stepping: Stepping | None = None
    microsteps: int | None = None
    swapped: str | None = None
    scale: float = 1.0
    time_offset_s: tuple[float, float, float] | None = None
    left_out: bool = False

    def to_dict(self) -> dict[str, object]:
        """Return the differences from the declaration, as estimate.json contains them."""
        own: dict[str, object] = {}
        if self.polarity < 0:
            own["polarity"] = -1
        if self.direction < 0:
            own["direction"] = -1
        if self.start_angle_deg is not None:
            own["start_angle_deg"] = self.start_angle_deg
        if self.rate is not None:
            own |= rate_entry(self.rate)
        own |= {key: getattr(self, key) for key in PLAIN if getattr(self, key) is not None}
        if self.scale != 1.0:
            own["scale"] = self.scale
        if self.time_offset_s is not None:
            own["time_offset_s"] = list(self.time_offset_s)
        if self.left_out:
            own["use"] = "validate"
        return own

    @classmethod
    def from_dict(cls, own: Mapping[str, Any]) -> Reading:
        """Return the reading that `to_dict` wrote."""
        delay = own.get("time_offset_s")
        return cls(
            polarity=own.get("polarity", 1),
            direction=own.get("direction", 1),
            start_angle_deg=own.get("start_angle_deg"),
            rate=_rate(own),
            **{key: own.get(key) for key in PLAIN},
            scale=own.get("scale", 1.0),
            time_offset_s=(delay[0], delay[1], delay[2]) if delay else None,
            left_out="use" in own,
        )

    @property
    def changes(self) -> int:
        """Number of differences from the declaration."""
        return len(self.to_dict())

    @property
    def factor(self) -> float:
        """Factor on the samples of the leading channel, including the polarity."""
        return self.polarity * self.scale

    def combine(self, further: Reading) -> Reading:
        """Return this reading with further differences, found while this one was applied."""
        new = {f.name: getattr(further, f.name) for f in fields(Reading) if getattr(further, f.name) != f.default}
        # Signs found on top of a reading multiply with its own; all other differences replace it.
        both = {"polarity": self.polarity * further.polarity, "direction": self.direction * further.direction}
        return replace(self, **(new | both))


DECLARED = Reading()


def rate_entry(rate: RateProfile) -> dict[str, object]:
    """Return the entry of a rate in a campaign file."""
    if len(rate.rates) == 1:
        return {"rate": rate.rates[0]}
    return {"rate_profile": [list(point) for point in zip(rate.times_s, rate.rates, strict=True)]}


def _rate(own: Mapping[str, Any]) -> RateProfile | None:
    if "rate" in own:
        return RateProfile.constant(own["rate"])
    return RateProfile.through(own["rate_profile"]) if "rate_profile" in own else None


def reinterpret_command(command: Command, reading: Reading) -> Command:
    """Return a command with the rate, stepping, direction and start angle of a reading."""
    if reading.rate is not None:
        command = replace(command, rate=reading.rate)
    if reading.stepping is not None and reading.microsteps is not None:
        # A table belongs to its number of microsteps.
        command = replace(command, stepping=reading.stepping, microsteps=reading.microsteps, table=())
    if reading.direction < 0:
        backward = RateProfile(command.rate.times_s, tuple(-rate for rate in command.rate.rates))
        command = replace(command, rate=backward)
    if reading.start_angle_deg is not None:
        command = replace(command, start_angle_deg=reading.start_angle_deg)
    return command


def reinterpret_offset(declared: Parameter, reading: Reading) -> Parameter:
    """Return a time offset of a reading, which is free if the reading has one."""
    if reading.time_offset_s is None:
        return declared
    value, least, most = reading.time_offset_s
    return replace(declared, value=value, min=least, max=most, status=Status.FREE)


def reinterpret_target(target: Target, reading: Reading) -> Target:
    """Return a target with the changes of a reading applied."""
    command = reinterpret_command(target.command, reading)
    own = target.with_time_offset(reinterpret_offset(target.time_offset, reading)) if reading.time_offset_s else target
    return replace(
        own,
        channels=(_scale_channel(target.leading, reading.factor), *target.channels[1:]),
        command=command,
        excitation=excitation_over(command, target.base, own.latest_s),
    )


def _scale_channel(channel: TargetChannel, factor: float) -> TargetChannel:
    if factor == 1.0:
        return channel
    size = abs(factor)
    return replace(
        channel,
        measured=_scale_series(factor, channel.measured),
        sigma=size * channel.sigma,
        rounding=size * channel.rounding,
    )


def _scale_series(factor: float, series: Series) -> Series:
    return map_samples(series, lambda values, part: factor * values)


def reinterpret_record(record: CampaignRecord, reading: Reading) -> CampaignRecord:
    """Return a record of the campaign with the changes of a reading applied."""
    if reading == DECLARED:
        return record
    if reading.time_offset_s is not None:
        own = reinterpret_offset(record.time_offset, reading)
        record = replace(record, parameters=tuple(own if q.name == own.name else q for q in record.parameters))
    if reading.factor != 1.0 and record.data is not None:
        channels = tuple(
            replace(c, data=_scale_series(reading.factor, c.data), scale=reading.factor * c.scale)
            if c.quantity == record.leading
            else c
            for c in record.data.channels
        )
        record = replace(record, data=replace(record.data, channels=channels))
    # A record left out of the fit is still simulated and shown.
    use = "validate" if reading.left_out else record.use
    return replace(record, command=reinterpret_command(record.command, reading), use=use)


def reinterpret_campaign(campaign: Campaign, readings: Mapping[str, Reading]) -> Campaign:
    """Return a campaign with readings applied to its records, by name."""
    records = tuple(reinterpret_record(record, readings.get(record.name, DECLARED)) for record in campaign.records)
    return replace(campaign, records=records) if readings else campaign


def reinterpret_problem(problem: Problem, readings: Mapping[str, Reading]) -> Problem:
    """Return a problem with readings applied to its targets, without those left out."""
    targets = tuple(
        reinterpret_target(t, readings[t.name]) if t.name in readings else t
        for t in problem.targets
        if not readings.get(t.name, DECLARED).left_out
    )
    return replace(problem, targets=targets)
