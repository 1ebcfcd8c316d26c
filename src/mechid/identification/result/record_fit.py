"""Fit of one record at the end of a search, with the initial and the final noise level of each channel."""

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
from mechid.signal.stored_series import WritableSeries, write_at
from mechid.signal.trend import Line
from mechid.simulation.simulator import TimeBase
from mechid.units import SI_UNIT


@dataclass(frozen=True)
class ChannelNoise:
    """Noise levels of a channel.

    Attributes
    ----------
    known : NoiseLevel
        Level before the fit.
    found : NoiseLevel
        The same, or the residual's RMS where the search raised the level.
    follows : float
        Standard deviation against which the model is judged to follow the record, in the SI unit.
    """

    known: NoiseLevel
    found: NoiseLevel
    follows: float


def channel_noises(record: CampaignRecord, targets: Sequence[Target]) -> dict[str, ChannelNoise]:
    """Return the noise of a record's channels by quantity, from the targets at the end of the fit.

    A channel that was not fitted takes the raised level of its quantity, if it was raised in all fitted channels.
    """
    return {match.quantity: _channel_noise(record, match, targets) for match in record.matches}


def _channel_noise(record: CampaignRecord, match: Match, targets: Sequence[Target]) -> ChannelNoise:
    known = known_noise(record, match)
    loudest = max(_raised_channels_alike(record, match, targets), key=lambda c: c.raised, default=None)
    if loudest is None or known.rests_on is NoiseSource.DECLARED or loudest.sigma <= known.sigma:
        return ChannelNoise(known, known, known.sigma)
    return ChannelNoise(known, NoiseLevel(loudest.sigma, NoiseSource.RESIDUAL), loudest.raised)


def _raised_channels_alike(record: CampaignRecord, match: Match, targets: Sequence[Target]) -> list[TargetChannel]:
    """Return the raised channels with the noise of a match: its own, or all of its quantity where it was not fitted."""
    fitted = [(t.name, c) for t in targets for c in t.channels if c.quantity == match.quantity]
    alike = [c for name, c in fitted if name == record.name] or [c for _, c in fitted]
    return alike if all(c.raised > 0.0 for c in alike) else []


def record_fit(record: CampaignRecord, problem: Problem, q: FloatArray, windows: Windows) -> RecordFit:
    """Return the fit of the model at `q` to a record, over its window or over the whole record without one."""
    target = next((t for t in problem.targets if t.name == record.name), None) or target_of(record)
    window = windows.get(record.name, (0, target.samples))
    noises = channel_noises(record, problem.targets)
    channels = _channel_fits(record, target, problem, q, window, noises)
    leading = channels[record.leading]
    judged = target.map_channels(lambda channel: replace(channel, sigma=noises[channel.quantity].follows))
    follows = followed_samples(problem, judged, q)
    whole = (0, target.samples)
    # The share of the whole record needs another simulation only where the window is a part of it.
    everywhere = channels if window == whole else _channel_fits(record, target, problem, q, whole, noises)
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


def _channel_fits(
    record: CampaignRecord,
    target: Target,
    problem: Problem,
    q: FloatArray,
    window: tuple[int, int],
    noises: Mapping[str, ChannelNoise],
) -> dict[str, ChannelFit]:
    """Return the fit of each channel; channels that are only compared come after the fitted ones."""
    others = [channel_of(record, match) for match in record.matches if match.quantity not in target.quantities]
    whole = replace(target, channels=(*target.channels, *others))
    matches = {match.quantity: match for match in record.matches}
    full_steps = _full_steps(target, problem)
    return {
        (name := channel.quantity): _channel_fit(
            record.use, matches[name], noises[name], whole, channel, r, window, full_steps.get(name)
        )
        for channel, r in zip(whole.channels, misfit_series(problem.model, whole, q, window), strict=True)
    }


def _channel_fit(
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
    # The masked moments are read first: `_residual` removes the line from r and zeroes rejected samples in place.
    masked = _masked_moments(channel, r, target.base, window, noise.found.sigma)
    rms, line = _residual(channel, r, rejected)
    spread = _centred_rms(stretch_of(channel.measured, first, stop), line, rejected)
    return ChannelFit(
        **_following_fields(channel, r, line, target.base, window, noise.known.sigma, full_step),
        unit=SI_UNIT[channel.quantity],
        use=match.use if use == "estimate" else use,
        fit_percent=100.0 * (1.0 - rms / spread) if spread > 0.0 else math.nan,
        residual_rms=rms,
        noise_sigma=noise.found.sigma,
        noise_rests_on=str(noise.found.rests_on),
        noise_known=noise.known.sigma,
        # The line counts samples from the start of the window; offset and phases refer to the record's first sample.
        offset=line.offset - line.slope * first if line and channel.linear > 0 else None,
        drift=line.slope * target.base.sample_rate_hz if line and channel.linear > 1 else None,
        lines=_lines(line, target.base, first) if line else (),
        quantisation=channel.rounding * math.sqrt(12.0),
        prefilter_order=channel.order,
        rejected=rejected.size,
        rejected_runs=runs_of(channel.rejected),
        masked=masked,
    )


def _masked_moments(
    channel: TargetChannel, r: Series, base: TimeBase, window: tuple[int, int], sigma: float
) -> tuple[MaskedMoment, ...]:
    """Return the moments within a window that the search left out, with their residuals."""
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
    """Return frequency in Hz, amplitude, and phase in rad at the record's first sample, of each removed line."""
    return tuple(
        (
            w.turns * base.sample_rate_hz,
            math.hypot(w.cosine, w.sine),
            math.remainder(math.atan2(-w.sine, w.cosine) - 2.0 * math.pi * w.turns * first, 2.0 * math.pi),
        )
        for w in line.waves
    )


def _full_steps(target: Target, problem: Problem) -> dict[str, float]:
    """Return a full step in rad by the angle that shows it; empty where no steps are commanded."""
    periods = problem.space.mechanism.electrical_periods
    if periods is None or isinstance(target.command, MeasuredCommand):
        return {}
    return {"rotor_angle": 2.0 * math.pi / problem.space.mechanism.full_steps / periods}


def _following_fields(
    channel: TargetChannel,
    r: Series,
    line: Line | None,
    base: TimeBase,
    window: tuple[int, int],
    noise: float,
    full_step: float | None,
) -> dict[str, Any]:
    """Return the fields of a ChannelFit that describe how far the model follows a channel."""
    first, stop = window
    rate, rejected = base.sample_rate_hz, channel.rejected_within(window)
    measured = Remainder(stretch_of(channel.measured, first, stop), line or Line(), rejected=rejected)
    # The mean over counted samples: rejected ones are zero in the remainder and must not lower it.
    if channel.linear:
        mean = Line(mean_of(measured) * measured.size / max(measured.size - rejected.size, 1))
        measured = replace(measured, line=replace(measured.line, offset=measured.line.offset + mean.offset))
    chance = chance_limit_of(max(SERIES.follow_window_s * rate, 1.0))
    found = assess_following(measured, r, rate, noise=noise, chance=chance)
    # Masked samples are zero in the residual and would count as followed.
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
    """Return the RMS of the misfit, and offset and drift of measured minus model; NaN, None for a failed run."""
    if not is_finite(r):
        return math.nan, None
    line = channel.line(r, rejected)
    line.subtract_from(r)
    write_at(r, rejected, 0.0)
    # The misfit is model minus measured; the reported line is measured minus model.
    return norm(r) / math.sqrt(max(r.size - rejected.size, 1)), -line


def _centred_rms(measured: Series, line: Line | None, rejected: Samples) -> float:
    """Return the RMS of measured - line - mean."""
    rest, n = Remainder(measured, line or Line(), rejected=rejected), max(measured.size - rejected.size, 1)
    mean = mean_of(rest) * rest.size / n
    squares = (float(np.sum(drop_rejected(rest[part] - mean, part, rejected) ** 2)) for part in blocks(rest.size))
    return math.sqrt(sum(squares) / n)
