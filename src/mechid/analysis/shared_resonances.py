"""Resonances confirmed by several records at different step rates, or by several orders of one record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mechid.analysis.look import RecordLook
from mechid.analysis.measured_resonances import MeasuredResonance
from mechid.analysis.settings import RESONANCE


@dataclass(frozen=True, kw_only=True)
class SharedResonance:
    """A confirmed resonance, with the records that show it."""

    frequency_hz: float
    records: tuple[str, ...]


@dataclass(frozen=True)
class _Seen:
    record: str
    rate: float | None
    found: MeasuredResonance


def shared_resonances(looks: Sequence[RecordLook]) -> tuple[SharedResonance, ...]:
    """Return the resonances of all records that certainly do not follow the rate, in order of frequency.

    Either several orders of one record peak at the frequency, or records with known and different step rates show it. A
    record with a varying rate counts as different from any other.
    """
    seen = [
        _Seen(look.record.name, look.constant_rate, found)
        for look in looks
        if look.rate is not None
        for channel in look.channels
        for found in channel.resonances
    ]
    groups: list[list[_Seen]] = []
    for one in sorted(seen, key=lambda each: each.found.frequency_hz):
        # Compared with the lowest of the group, so that a chain of close frequencies does not merge.
        if groups and one.found.frequency_hz <= groups[-1][0].found.frequency_hz * (1.0 + RESONANCE.alike):
            groups[-1].append(one)
        else:
            groups.append([one])
    return tuple(_merge_group(group) for group in groups if _is_confirmed(group))


def _is_confirmed(group: Sequence[_Seen]) -> bool:
    if any(one.found.orders for one in group):
        return True
    rates = {one.record: one.rate for one in group}
    constant = [rate for rate in rates.values() if rate is not None]
    # At equal rates an order of the step rate would appear at the same frequency.
    differ = bool(constant) and max(constant) > (1.0 + RESONANCE.rates_apart) * min(constant)
    return len(rates) > 1 and (differ or len(constant) < len(rates))


def _merge_group(group: Sequence[_Seen]) -> SharedResonance:
    tracked = [one.found.frequency_hz for one in group if one.found.orders]
    frequency = float(np.median(tracked or [one.found.frequency_hz for one in group]))
    return SharedResonance(frequency_hz=frequency, records=tuple(dict.fromkeys(one.record for one in group)))
