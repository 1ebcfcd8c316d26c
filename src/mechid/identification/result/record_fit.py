"""Fit of one record at the end of a search, with the noise of each channel as known and as the fit leaves it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import CampaignRecord, Match
from mechid.command import MeasuredCommand
from mechid.identification.output_error.misfit import misfit_series
from mechid.identification.output_error.noise_level import NoiseLevel, NoiseSource, known_noise
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.target import Samples, Target, TargetChannel, channel_of, target_of
from mechid.identification.result.record_result import ChannelFit, MaskedMoment, RecordFit
from mechid.identification.search.horizons import chance_limit_of, followed_samples
from mechid.signal.following import assess_following, first_out_of_step
from mechid.signal.moments import norm
from mechid.signal.remainder import Remainder
from mechid.signal.runs import runs_of
from mechid.signal.series import Series, blocks, drop_rejected, is_finite, mean_of, stretch_of
from mechid.signal.settings import SERIES
from mechid.signal.stored import WritableSeries, write_at
from mechid.signal.trend import Line
from mechid.simulation.simulator import TimeBase
from mechid.units import SI_UNIT


@dataclass(frozen=True)
class ChannelNoise:
    """Noise of a channel.

    Attributes
    ----------
    known : NoiseLevel
        Before the fit.
    found : NoiseLevel
        The same, or the residual's RMS where the search raised the level.
    follows : float
        Standard deviation by which it is judged how far the model follows the record, in the SI unit.
    """

    known: NoiseLevel
    found: NoiseLevel
    follows: float


def channel_noises(record: CampaignRecord, targets: Sequence[Target]) -> dict[str, ChannelNoise]:
    """Return the noise of a record's channels by quantity, with the targets as the fit leaves them.

    What is not fitted takes the level to which its quantity was raised in all that is fitted.
    """
    return {match.quantity: _channel_noise(record, match, targets) for match in record.matches}


def _channel_noise(record: CampaignRecord, match: Match, targets: Sequence[Target]) -> ChannelNoise:
    known = known_noise(record, match)
    loudest = max(_like(record, match, targets), key=lambda c: c.raised, default=None)
    if loudest is None or known.rests_on is NoiseSource.DECLARED or loudest.sigma <= known.sigma:
        return ChannelNoise(known, known, known.sigma)
    return ChannelNoise(known, NoiseLevel(loudest.sigma, NoiseSource.RESIDUAL), loudest.raised)


def _like(record: CampaignRecord, match: Match, targets: Sequence[Target]) -> list[TargetChannel]:
    """Return the raised channels whose noise is that of a match: its own, or where it is not fitted all of its kind."""
    fitted = [(t.name, c) for t in targets for c in t.channels if c.quantity == match.quantity]
    alike = [c for name, c in fitted if name == record.name] or [c for _, c in fitted]
    return alike if all(c.raised > 0.0 for c in alike) else []


def record_fit(record: CampaignRecord, problem: Problem, q: FloatArray, windows: Windows) -> RecordFit:
    """Return how the model at `q` predicts a record over its window, or over all of it where it has none."""
    target = next((t for t in problem.targets if t.name == record.name), None) or target_of(record)
    window = windows.get(record.name, (0, target.samples))
    noises = channel_noises(record, problem.targets)
    channels = _channels(record, target, problem, q, window, noises)
    leading = channels[record.leading]
    judged = target.each(lambda channel: replace(channel, sigma=noises[channel.quantity].follows))
    follows = followed_samples(problem, judged, q)
    whole = (0, target.samples)
    everywhere = channels if window == whole else _channels(record, target, problem, q, whole, noises)
    return RecordFit(
        name=record.name,
        use=record.use,
        samples=window[1] - window[0],
        fit_percent=leading.fit_percent,
        residual_rms=leading.residual_rms,
        noise_sigma=leading.noise_sigma,
        offset=leading.offset,
        drift=leading.drift,
        prefilter_order=leading.prefilter_order,
        rejected=leading.rejected,
        horizon_s=max(follows - 1, 0) / target.base.sample_rate_hz,
        channels=channels,
        followed_of_whole=min(c.followed_percent for c in everywhere.values()),
    )


def _channels(
    record: CampaignRecord,
    target: Target,
    problem: Problem,
    q: FloatArray,
    window: tuple[int, int],
    noises: Mapping[str, ChannelNoise],
) -> dict[str, ChannelFit]:
    """Return how each channel is predicted, those that are only compared behind those that are fitted."""
    others = [channel_of(record, match) for match in record.matches if match.quantity not in target.quantities]
    whole = replace(target, channels=(*target.channels, *others))
    matches = {match.quantity: match for match in record.matches}
    full_steps = _full_steps(target, problem)
    return {
        (name := channel.quantity): _channel(
            record.use, matches[name], noises[name], whole, channel, r, window, full_steps.get(name)
        )
        for channel, r in zip(whole.channels, misfit_series(problem.model, whole, q, window), strict=True)
    }


def _channel(
    use: str,
    match: Match,
    noise: ChannelNoise,
    target: Target,
    channel: TargetChannel,
    r: WritableSeries,
    window: tuple[int, int],
    full_step: float | None,
) -> ChannelFit:
    first, stop = window
    rejected = channel.rejected_within(window)
    masked = _masked(channel, r, target.base, window, noise.found.sigma)
    rms, line = _residual(channel, r, rejected)
    spread = _spread(stretch_of(channel.measured, first, stop), line, rejected)
    return ChannelFit(
        **_followed(channel, r, line, target.base, window, noise.known.sigma, full_step),
        unit=SI_UNIT[channel.quantity],
        use=match.use if use == "estimate" else use,
        fit_percent=100.0 * (1.0 - rms / spread) if spread > 0.0 else math.nan,
        residual_rms=rms,
        noise_sigma=noise.found.sigma,
        noise_rests_on=str(noise.found.rests_on),
        noise_known=noise.known.sigma,
        offset=line.offset - line.slope * first if line and channel.linear > 0 else None,
        drift=line.slope * target.base.sample_rate_hz if line and channel.linear > 1 else None,
        lines=_lines(line, target.base, first) if line else (),
        quantisation=channel.rounding * math.sqrt(12.0),
        prefilter_order=channel.order,
        rejected=rejected.size,
        rejected_runs=runs_of(channel.rejected),
        masked=masked,
    )


def _masked(
    channel: TargetChannel, r: Series, base: TimeBase, window: tuple[int, int], sigma: float
) -> tuple[MaskedMoment, ...]:
    """Return the moments within a window that the search left out, with what the model leaves of them."""
    first, stop = window
    inside = channel.masked[(channel.masked >= first) & (channel.masked < stop)]
    if not inside.size:
        return ()
    line = channel.line(r, channel.rejected_within(window))

    def moment(begins: int, ends: int) -> MaskedMoment:
        off = r[begins - first : ends - first] - line.at(begins - first, ends - first)
        largest = float(np.max(np.abs(off)))
        return MaskedMoment(
            first=begins,
            stop=ends,
            from_s=base.start_s + begins / base.sample_rate_hz,
            to_s=base.start_s + ends / base.sample_rate_hz,
            largest=largest,
            over_noise=largest / sigma,
            chi_square=float(np.sum((off / sigma) ** 2)) - off.size,
        )

    return tuple(moment(*run) for run in runs_of(inside))


def _lines(line: Line, base: TimeBase, first: int) -> tuple[tuple[float, float, float], ...]:
    """Return frequency in Hz, amplitude and phase in rad at the record's first sample of each line removed."""
    return tuple(
        (
            w.turns * base.sample_rate_hz,
            math.hypot(w.cosine, w.sine),
            math.remainder(math.atan2(-w.sine, w.cosine) - 2.0 * math.pi * w.turns * first, 2.0 * math.pi),
        )
        for w in line.waves
    )


def _full_steps(target: Target, problem: Problem) -> dict[str, float]:
    """Return a full step in rad by the angle that tells it; none where the record is not commanded by steps."""
    periods = problem.space.mechanism.electrical_periods
    if periods is None or isinstance(target.command, MeasuredCommand):
        return {}
    return {"rotor_angle": 0.5 * math.pi / periods}


def _followed(
    channel: TargetChannel,
    r: Series,
    line: Line | None,
    base: TimeBase,
    window: tuple[int, int],
    noise: float,
    full_step: float | None,
) -> dict[str, Any]:
    """Return how far a channel is followed, by the names that a ChannelFit has for it."""
    first, stop = window
    rate, rejected = base.sample_rate_hz, channel.rejected_within(window)
    measured = Remainder(stretch_of(channel.measured, first, stop), line or Line(), rejected=rejected)
    if channel.linear:
        mean = Line(mean_of(measured) * measured.size / max(measured.size - rejected.size, 1))
        measured = replace(measured, line=replace(measured.line, offset=measured.line.offset + mean.offset))
    chance = chance_limit_of(max(SERIES.follow_window_s * rate, 1.0))
    found = assess_following(measured, r, rate, noise=noise, chance=chance)
    masked = int(np.sum((channel.masked >= first) & (channel.masked < stop)))
    late = first_out_of_step(r, rate, full_step) if full_step else None

    def instant(sample: int) -> float:
        return base.start_s + (first + sample) / rate

    return {
        "followed_percent": 100.0 * max(found.share - masked / r.size, 0.0),
        "lost_at_s": None if found.lost is None else instant(found.lost),
        "worst_at_s": instant(found.worst_at),
        "worst": found.worst,
        "out_of_step_at_s": None if late is None else instant(late),
    }


def _residual(channel: TargetChannel, r: WritableSeries, rejected: Samples) -> tuple[float, Line | None]:
    """Return the RMS of the misfit, and offset and drift of measured over model; NaN, None for a failed run."""
    if not is_finite(r):
        return math.nan, None
    line = channel.line(r, rejected)
    line.subtract_from(r)
    write_at(r, rejected, 0.0)
    return norm(r) / math.sqrt(max(r.size - rejected.size, 1)), -line


def _spread(measured: Series, line: Line | None, rejected: Samples) -> float:
    """Return the RMS of measured - line - mean."""
    rest, n = Remainder(measured, line or Line(), rejected=rejected), max(measured.size - rejected.size, 1)
    mean = mean_of(rest) * rest.size / n
    squares = (float(np.sum(drop_rejected(rest[part] - mean, part, rejected) ** 2)) for part in blocks(rest.size))
    return math.sqrt(sum(squares) / n)
