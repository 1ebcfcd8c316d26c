"""Noise levels changed during a search: raised where growth stalls, lowered to what a model leaves.

A position or a current has no high frequencies, so that its high-frequency floor says nothing of its noise, and what
a model misses of a real mechanism is not noise. Within a level that is too low no record is followed; a level a few
times the residual that can be reached is as good as any for finding the way there.

Impacts, as of teeth in a gear with backlash, fill the spectrum up to the Nyquist frequency, and a level read there may
be twice that of the noise. Within it a wrong branch, or a missing effect, looks like noise. What a model leaves of a
stretch that it follows holds all of the noise, so that no level stands above it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from mechid.arrays import FloatArray
from mechid.campaign import Campaign, CampaignRecord
from mechid.identification.output_error.noise_level import NoiseSource, known_noise
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.identification.result.record_result import ChannelFit, RecordFit
from mechid.identification.search.gates import Growth
from mechid.identification.search.horizons import followed_samples
from mechid.identification.uncertainty.covariance import residual, residuals_by_quantity
from mechid.identification.uncertainty.noise import each_target
from mechid.identification.uncertainty.settings import NOISE
from mechid.signal.moments import norm, standard_deviation
from mechid.signal.noise import FLOOR_ERROR
from mechid.signal.remainder import Remainder
from mechid.signal.series import Series
from mechid.signal.trend import fit_line
from mechid.units import unit_words


def raise_levels(problem: Problem, growth: Growth) -> Problem:
    """Return the problem with a higher level of the channels that stop a growth; the same one where none may rise."""
    return each_target(problem, lambda target: _raised(problem, target, growth))


def _raised(problem: Problem, target: Target, growth: Growth) -> Target:
    gate = growth.horizons[target.name]
    if gate == target.samples:
        return target
    stops = _stopping(problem, target, growth, gate)
    return target.map_channels(lambda channel: _raised_channel(channel) if channel.quantity in stops else channel)


def _stopping(problem: Problem, target: Target, growth: Growth, gate: int) -> list[str]:
    """Return the quantities that the model does not follow beyond the gate."""
    alone = {c.quantity: followed_samples(problem, replace(target, channels=(c,)), growth.q) for c in target.channels}
    first = max(gate, min(alone.values()))
    return [quantity for quantity, samples in alone.items() if samples <= first]


def with_saved_levels(problem: Problem, records: Mapping[str, RecordFit]) -> Problem:
    """Return the problem with the noise levels that the search of a fit has raised."""

    def one(target: Target) -> Target:
        found = records[target.name].channels
        return target.map_channels(lambda channel: _at_level(channel, found.get(channel.quantity)))

    return replace(problem, targets=tuple(map(one, problem.targets)))


def _at_level(channel: TargetChannel, found: ChannelFit | None) -> TargetChannel:
    if found is None or found.noise_rests_on != NoiseSource.RESIDUAL:
        return channel
    level = float(found.noise_sigma)
    return replace(channel, sigma=level, raised=level, rests_on=NoiseSource.RESIDUAL)


def _raised_channel(channel: TargetChannel) -> TargetChannel:
    """Return a channel at a higher level; the same one where its level is declared, or as high as it may be."""
    level = min(NOISE.raise_factor * channel.sigma, NOISE.most_raised_share * moving_deviation(channel))
    if channel.rests_on is NoiseSource.DECLARED or level <= channel.sigma:
        return channel
    return replace(channel, sigma=level, raised=level, rests_on=NoiseSource.RESIDUAL)


def explains_most(problem: Problem, q: FloatArray) -> bool:
    """Tell whether a point leaves less than a twentieth of what moves in every channel: then no record contradicts."""

    def share(target: Target) -> float:
        series = residual(problem, target, q, (0, target.samples))
        return max(
            standard_deviation(r) / max(moving_deviation(c), 1e-300)
            for c, r in zip(target.channels, series, strict=True)
        )

    return max(map(share, problem.targets)) < NOISE.mostly_explained


def moving_deviation(channel: TargetChannel) -> float:
    """Return the standard deviation of a channel, offset and drift removed where the channel's zero is free."""
    line = fit_line(channel.measured, 2 if channel.linear else 1, channel.rejected)
    return standard_deviation(Remainder(channel.measured, line), channel.rejected)


def describe_raised_levels(problem: Problem, growth: Growth) -> str:
    """Return what the levels of unfinished records have been raised to, and how far these were followed below it."""
    words = []
    for t in problem.targets:
        levels = [f"{c.quantity} {c.raised:.3g} {unit_words(c.quantity)}" for c in t.channels if c.raised]
        if growth.horizons[t.name] < t.samples and levels:
            seconds, of = growth.horizons[t.name] / t.base.sample_rate_hz, t.samples / t.base.sample_rate_hz
            words.append(
                f"record {t.name} to {' and '.join(levels)}: followed {seconds:.3g} s of {of:.3g} s below that"
            )
    return "; ".join(words)


def raised_warnings(campaign: Campaign, targets: Sequence[Target], before: Mapping[str, str]) -> list[str]:
    """Say of each record whose levels were raised from where, what they ended at, and why.

    Parameters
    ----------
    campaign : Campaign
    targets : sequence of Target
        As the search has ended.
    before : mapping of str to str
        How far each record was followed at the levels known beforehand, in words.
    """
    lines = []
    for target in targets:
        record = campaign.record(target.name)
        levels = [_level_words(record, c) for c in target.channels if c.raised > 0.0]
        if levels:
            why = f"; at the level known beforehand {before[target.name]}" if target.name in before else ""
            lines.append(
                f"record {target.name}: to follow it the noise level was raised, {', '.join(levels)}, the RMS of the "
                "residual: how much of that is noise, and how much the model lacks, the record alone does not show"
                f"{why}"
            )
    return lines


def _level_words(record: CampaignRecord, channel: TargetChannel) -> str:
    known = known_noise(record, next(m for m in record.matches if m.quantity == channel.quantity))
    return (
        f"of {channel.quantity} from {known.sigma:.3g} ({known.rests_on}) to {channel.raised:.3g} "
        f"{unit_words(channel.quantity)}, and ended at {channel.sigma:.3g}"
    )


def lower_levels(problem: Problem, q: FloatArray, windows: Windows) -> Problem:
    """Return the problem with no level above what `q` leaves in the windows; the same one where none is clearly above.

    A level that rests on more than high frequencies stays, and none falls below that of the resolution.
    """
    return each_target(problem, lambda t: _lowered(problem, t, q, windows[t.name]) if t.name in windows else t)


def _lowered(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]) -> Target:
    series = residuals_by_quantity(problem, target, q, window)
    return target.map_channels(lambda channel: _at_most(channel, series[channel.quantity], window))


def _at_most(channel: TargetChannel, r: Series, window: tuple[int, int]) -> TargetChannel:
    counted = r.size - channel.rejected_within(window).size
    if channel.rests_on is not NoiseSource.FLOOR or channel.prefilter or counted < NOISE.least_samples:
        return channel
    level = max(norm(r) / math.sqrt(counted), channel.rounding)
    clearly = 1.0 - NOISE.sure * math.hypot(FLOOR_ERROR, math.sqrt(0.5)) / math.sqrt(counted)
    return replace(channel, sigma=level) if level < clearly * channel.sigma else channel


def noise_levels(problem: Problem) -> dict[tuple[str, str], float]:
    """Return the noise level of each record's channels, by record and quantity, SI."""
    return {(t.name, c.quantity): c.sigma for t in problem.targets for c in t.channels}


def with_levels_of(problem: Problem, other: Problem) -> Problem:
    """Return a problem with the levels of another one of the same records and channels."""
    known = noise_levels(other)

    def one(target: Target) -> Target:
        return target.map_channels(lambda c: replace(c, sigma=known.get((target.name, c.quantity), c.sigma)))

    return replace(problem, targets=tuple(map(one, problem.targets)))
