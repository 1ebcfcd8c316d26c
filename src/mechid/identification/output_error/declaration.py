"""Reading of a record: how it was driven and wired, as its campaign file declares it or as reinterpreted."""

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
from mechid.signal.stored import map_samples
from mechid.simulation.simulator import excitation_over

PLAIN = ("stepping", "microsteps", "swapped")
"""What `Reading` holds of a command and estimate.json writes as it is."""


@dataclass(frozen=True, kw_only=True)
class Reading:
    """How a record is read where that is not as declared; as declared by default.

    Attributes
    ----------
    polarity : int
        -1 where the leading channel, the torque where there is one, has the other sign.
    direction : int
        -1 where the commanded rate has the other sign.
    start_angle_deg : float or None
        Electrical start angle in degrees.
    rate : RateProfile or None
        Commanded rate, before its direction.
    stepping : str or None
        With `microsteps`, steps a full step.
    swapped : str or None
        The record whose command it has, in exchange for its own.
    scale : float
        What the leading channel's samples are multiplied by.
    time_offset_s : (float, float, float) or None
        Value, lower and upper bound of a time offset that is to be estimated, s.
    left_out : bool
        Whether the record is kept out of the fit.
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
        """Return what differs from the declaration, as estimate.json writes it."""
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
        """Return what `to_dict` wrote down."""
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
        """How many things differ from the declaration."""
        return len(self.to_dict())

    @property
    def factor(self) -> float:
        """What the samples of the leading channel are multiplied by."""
        return self.polarity * self.scale

    def beside(self, further: Reading) -> Reading:
        """Return it with what was found further, of a record that is taken so already."""
        new = {f.name: getattr(further, f.name) for f in fields(Reading) if getattr(further, f.name) != f.default}
        both = {"polarity": self.polarity * further.polarity, "direction": self.direction * further.direction}
        return replace(self, **(new | both))


DECLARED = Reading()


def rate_entry(rate: RateProfile) -> dict[str, object]:
    """Return a rate as a campaign file writes it."""
    if len(rate.rates) == 1:
        return {"rate": rate.rates[0]}
    return {"rate_profile": [list(point) for point in zip(rate.times_s, rate.rates, strict=True)]}


def _rate(own: Mapping[str, Any]) -> RateProfile | None:
    if "rate" in own:
        return RateProfile.constant(own["rate"])
    return RateProfile.through(own["rate_profile"]) if "rate_profile" in own else None


def command_as_read(command: Command, taken: Reading) -> Command:
    """Return a command at the rate, in the steps and direction, and from the start angle that were taken."""
    if taken.rate is not None:
        command = replace(command, rate=taken.rate)
    if taken.stepping is not None and taken.microsteps is not None:
        command = replace(command, stepping=taken.stepping, microsteps=taken.microsteps)
    if taken.direction < 0:
        backward = RateProfile(command.rate.times_s, tuple(-rate for rate in command.rate.rates))
        command = replace(command, rate=backward)
    if taken.start_angle_deg is not None:
        command = replace(command, start_angle_deg=taken.start_angle_deg)
    return command


def offset_as_read(declared: Parameter, taken: Reading) -> Parameter:
    """Return a time offset as it was taken: to be estimated where that is so."""
    if taken.time_offset_s is None:
        return declared
    value, least, most = taken.time_offset_s
    return replace(declared, value=value, min=least, max=most, status=Status.FREE)


def target_as_read(target: Target, taken: Reading) -> Target:
    """Return what is to be matched as it was taken."""
    command = command_as_read(target.command, taken)
    own = target.with_time_offset(offset_as_read(target.time_offset, taken)) if taken.time_offset_s else target
    return replace(
        own,
        channels=(_multiplied(target.leading, taken.factor), *target.channels[1:]),
        command=command,
        excitation=excitation_over(command, target.base, own.latest_s),
    )


def _multiplied(channel: TargetChannel, factor: float) -> TargetChannel:
    if factor == 1.0:
        return channel
    size = abs(factor)
    return replace(
        channel, measured=_times(factor, channel.measured), sigma=size * channel.sigma, rounding=size * channel.rounding
    )


def _times(factor: float, series: Series) -> Series:
    return map_samples(series, lambda values, part: factor * values)


def record_as_read(record: CampaignRecord, taken: Reading) -> CampaignRecord:
    """Return a record of the campaign as it was taken."""
    if taken == DECLARED:
        return record
    if taken.time_offset_s is not None:
        own = offset_as_read(record.time_offset, taken)
        record = replace(record, parameters=tuple(own if q.name == own.name else q for q in record.parameters))
    if taken.factor != 1.0 and record.data is not None:
        channels = tuple(
            replace(c, data=_times(taken.factor, c.data), scale=taken.factor * c.scale)
            if c.quantity == record.leading
            else c
            for c in record.data.channels
        )
        record = replace(record, data=replace(record.data, channels=channels))
    use = "validate" if taken.left_out else record.use
    return replace(record, command=command_as_read(record.command, taken), use=use)


def campaign_as_read(campaign: Campaign, taken: Mapping[str, Reading]) -> Campaign:
    """Return a campaign with its records as they were taken."""
    records = tuple(record_as_read(record, taken.get(record.name, DECLARED)) for record in campaign.records)
    return replace(campaign, records=records) if taken else campaign


def problem_as_read(problem: Problem, taken: Mapping[str, Reading]) -> Problem:
    """Return a problem with its targets as they were taken, those left out dropped."""
    targets = tuple(
        target_as_read(t, taken[t.name]) if t.name in taken else t
        for t in problem.targets
        if not taken.get(t.name, DECLARED).left_out
    )
    return replace(problem, targets=targets)
