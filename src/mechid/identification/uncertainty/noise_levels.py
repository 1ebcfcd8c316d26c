"""Noise levels during a search: raised where growth stalls, lowered to the residual of a good fit.

A position or a current has no high frequencies, so its high-frequency floor does not show its noise, and a real
mechanism also has effects that the model lacks. Against a level that is too low, no record counts as followed. A level
a few times the attainable residual is enough to find the way there.

Impacts, such as those of gear teeth with backlash, fill the spectrum up to the Nyquist frequency, and a level read
there may be twice that of the noise. Below such a level a wrong branch or a missing effect looks like noise. The
residual of a stretch that the model follows contains all of the noise, so the level is lowered to that residual.
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
from mechid.identification.uncertainty.noise import change_each_target
from mechid.identification.uncertainty.settings import NOISE
from mechid.signal.moments import norm, standard_deviation
from mechid.signal.noise import FLOOR_ERROR
from mechid.signal.remainder import Remainder
from mechid.signal.series import Series
from mechid.signal.trend import fit_line
from mechid.units import unit_words


def raise_levels(problem: Problem, growth: Growth) -> Problem:
    """Raise the level of the channels that stop a growth; return the same problem where none may rise."""
    return change_each_target(problem, lambda target: _raise_target(problem, target, growth))


def _raise_target(problem: Problem, target: Target, growth: Growth) -> Target:
    gate = growth.horizons[target.name]
    if gate == target.samples:
        return target
    stops = _stopping_quantities(problem, target, growth, gate)
    return target.map_channels(lambda channel: _raise_channel(channel) if channel.quantity in stops else channel)


def _stopping_quantities(problem: Problem, target: Target, growth: Growth, gate: int) -> list[str]:
    """Return the quantities that the model does not follow beyond the gate."""
    # Where every channel alone passes the gate, the one that is lost first still has to be raised.
    alone = {c.quantity: followed_samples(problem, replace(target, channels=(c,)), growth.q) for c in target.channels}
    first = max(gate, min(alone.values()))
    return [quantity for quantity, samples in alone.items() if samples <= first]


def restore_levels(problem: Problem, records: Mapping[str, RecordFit]) -> Problem:
    """Restore the noise levels that the search of a stored fit raised."""

    def one(target: Target) -> Target:
        found = records[target.name].channels
        return target.map_channels(lambda channel: _restore_channel_level(channel, found.get(channel.quantity)))

    return replace(problem, targets=tuple(map(one, problem.targets)))


def _restore_channel_level(channel: TargetChannel, found: ChannelFit | None) -> TargetChannel:
    if found is None or found.noise_rests_on != NoiseSource.RESIDUAL:
        return channel
    level = float(found.noise_sigma)
    return replace(channel, sigma=level, raised=level, rests_on=NoiseSource.RESIDUAL)


def _raise_channel(channel: TargetChannel) -> TargetChannel:
    """Raise a channel's level by one step; return the same channel where it is declared or at its maximum."""
    level = min(NOISE.raise_factor * channel.sigma, NOISE.most_raised_share * moving_deviation(channel))
    if channel.rests_on is NoiseSource.DECLARED or level <= channel.sigma:
        return channel
    return replace(channel, sigma=level, raised=level, rests_on=NoiseSource.RESIDUAL)


def explains_most(problem: Problem, q: FloatArray) -> bool:
    """Tell whether the residual of every channel at `q` is below a twentieth of the channel's own variation."""

    def share(target: Target) -> float:
        series = residual(problem, target, q, (0, target.samples))
        return max(
            standard_deviation(r) / max(moving_deviation(c), 1e-300)
            for c, r in zip(target.channels, series, strict=True)
        )

    return max(map(share, problem.targets)) < NOISE.mostly_explained


def moving_deviation(channel: TargetChannel) -> float:
    """Return the standard deviation of a channel, less its offset, and less its drift where the channel allows one."""
    line = fit_line(channel.measured, 2 if channel.linear else 1, channel.rejected)
    return standard_deviation(Remainder(channel.measured, line), channel.rejected)


def describe_raised_levels(problem: Problem, growth: Growth) -> str:
    """Describe the raised levels of unfinished records, and the time up to which each was followed."""
    words = []
    for t in problem.targets:
        levels = [f"{c.quantity} {c.raised:.3g} {unit_words(c.quantity)}" for c in t.channels if c.raised]
        if growth.horizons[t.name] < t.samples and levels:
            seconds, of = growth.horizons[t.name] / t.base.sample_rate_hz, t.samples / t.base.sample_rate_hz
            words.append(
                f"record {t.name} to {' and '.join(levels)}: at lower levels followed for {seconds:.3g} s of {of:.3g} s"
            )
    return "; ".join(words)


def raised_level_warnings(campaign: Campaign, targets: Sequence[Target], before: Mapping[str, str]) -> list[str]:
    """Report each record whose levels were raised: initial, raised and final level, and the reason.

    Parameters
    ----------
    campaign : Campaign
    targets : sequence of Target
        Targets at the end of the search.
    before : mapping of str to str
        Description of how far each record was followed at its initial levels.
    """
    lines = []
    for target in targets:
        record = campaign.record(target.name)
        levels = [_level_words(record, c) for c in target.channels if c.raised > 0.0]
        if levels:
            why = f"; at its initial level {before[target.name]}" if target.name in before else ""
            lines.append(
                f"record {target.name}: to follow it the noise level was raised, {', '.join(levels)}, the RMS of the "
                f"residual; the record alone does not show how much of that is noise and how much is model error{why}"
            )
    return lines


def _level_words(record: CampaignRecord, channel: TargetChannel) -> str:
    known = known_noise(record, next(m for m in record.matches if m.quantity == channel.quantity))
    return (
        f"of {channel.quantity} from {known.sigma:.3g} ({known.rests_on}) to {channel.raised:.3g} "
        f"{unit_words(channel.quantity)}, and ended at {channel.sigma:.3g}"
    )


def lower_levels(problem: Problem, q: FloatArray, windows: Windows) -> Problem:
    """Lower each level to the residual RMS at `q` within the windows; return the same problem where none is above.

    Only levels that rest on the high-frequency floor are lowered, and none falls below that of the resolution.
    """
    return change_each_target(
        problem, lambda t: _lower_target(problem, t, q, windows[t.name]) if t.name in windows else t
    )


def _lower_target(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]) -> Target:
    series = residuals_by_quantity(problem, target, q, window)
    return target.map_channels(lambda channel: _lower_channel(channel, series[channel.quantity], window))


def _lower_channel(channel: TargetChannel, r: Series, window: tuple[int, int]) -> TargetChannel:
    counted = r.size - channel.rejected_within(window).size
    if channel.rests_on is not NoiseSource.FLOOR or channel.prefilter or counted < NOISE.least_samples:
        return channel
    level = max(norm(r) / math.sqrt(counted), channel.rounding)
    # Relative standard errors of the floor and of the residual's RMS: levels closer than these differ by chance.
    clearly = 1.0 - NOISE.lowering_errors * math.hypot(FLOOR_ERROR, math.sqrt(0.5)) / math.sqrt(counted)
    return replace(channel, sigma=level) if level < clearly * channel.sigma else channel


def noise_levels(problem: Problem) -> dict[tuple[str, str], float]:
    """Return the noise level of each record's channels, by record and quantity, SI."""
    return {(t.name, c.quantity): c.sigma for t in problem.targets for c in t.channels}


def copy_levels(problem: Problem, other: Problem) -> Problem:
    """Copy the noise levels from another problem with the same records and channels."""
    known = noise_levels(other)

    def one(target: Target) -> Target:
        return target.map_channels(lambda c: replace(c, sigma=known.get((target.name, c.quantity), c.sigma)))

    return replace(problem, targets=tuple(map(one, problem.targets)))
