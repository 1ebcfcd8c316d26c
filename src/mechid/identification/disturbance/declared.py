"""A disturbance as a campaign file declares it, and one that an earlier fit has found, put back into the campaign."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from mechid.campaign import Campaign, CampaignRecord
from mechid.campaign.campaign import CAMPAIGN, CLOCK, TIME_OFFSET, key_in_record
from mechid.campaign.identify_options import MAINS
from mechid.campaign.record_tables import OWN
from mechid.campaign.test_stand_entry import KEY as TEST_STAND
from mechid.identification.disturbance.disturbance import Disturbance, with_own
from mechid.parameter import Parameter, Status
from mechid.plant.plant import Plant


@dataclass(frozen=True, kw_only=True)
class Declared:
    """A record's own parameter as the fit began with it: its start, bounds and prior, in its unit."""

    start: float
    min: float
    max: float
    sigma: float | None

    @classmethod
    def bounded(cls, start: float, low: float | None, high: float | None, sigma: float | None) -> Declared:
        """Return it from what estimate.json writes, in which no bound is none."""
        return cls(
            start=start, min=-math.inf if low is None else low, max=math.inf if high is None else high, sigma=sigma
        )


def declared_toml(one: Disturbance, values: Mapping[str, float]) -> str:
    """Return the tables that declare a disturbance at some values, for the end of a campaign file."""
    lines: list[str] = []
    shared = [p for p in one.parameters if p.name.startswith(f"{CAMPAIGN}.")]
    if shared:
        lines += [f"[[{CAMPAIGN}]]", *(f"{p.declaration.key} = {_entry(p, values[p.name])}" for p in shared), ""]
    if one.seen_hz:
        lines += [f"[[{CAMPAIGN}]]", f"{MAINS} = {one.seen_hz!r}", ""]
    for record, own in one.own.items():
        entries = [_line(key_in_record(p.name), _entry(p, values[p.name])) for p in own if p not in shared]
        lines += [f"[[{OWN}]]", f'record = "{record}"', *entries, ""] if entries else []
    return "\n".join(lines)


def _line(key: str, entry: str) -> str:
    return f"{TEST_STAND} = {{ {key} = {entry} }}" if "." in key else f"{key} = {entry}"


def _entry(p: Parameter, value: float) -> str:
    sigma = f", sigma = {p.sigma!r}" if p.sigma else ""
    return f"{{ value = {value!r}, min = {p.min!r}, max = {p.max!r}{sigma} }}"


def recalled(campaign: Campaign, found: Mapping[str, Declared]) -> Campaign:
    """Return a campaign whose records have the parameters that an earlier fit has found, by dotted name."""
    plant = campaign.mechanism.plant
    return replace(campaign, records=tuple(recalled_record(r, found, plant) for r in campaign.records))


def recalled_record(record: CampaignRecord, found: Mapping[str, Declared], plant: Plant) -> CampaignRecord:
    """Return a record with the parameters that an earlier fit has found of it, free."""
    prefixes = f"record.{record.name}.", f"{CAMPAIGN}."
    own = (_parameter(name, given, plant) for name, given in found.items() if name.startswith(prefixes))
    return with_own(record, own)


def _parameter(name: str, given: Declared, plant: Plant) -> Parameter:
    key = name.removeprefix(f"{CAMPAIGN}.") if name.startswith(f"{CAMPAIGN}.") else key_in_record(name)
    instants = {d.key: d for d in (TIME_OFFSET, CLOCK)}
    replaces = "" if key in instants else plant.of_record[key]
    return Parameter(
        name=name,
        value=given.start,
        declaration=instants.get(key) or plant.declarations[replaces],
        min=given.min,
        max=given.max,
        sigma=given.sigma,
        status=Status.FREE,
        replaces=replaces,
    )
