"""Noise of each channel of each record: held at its floor during the search, released at the end."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign.identify_options import IdentifyOptions
from mechid.identification.output_error.noise_level import SMALLEST
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.identification.search.horizons import chance_limit_of, gate_window
from mechid.identification.uncertainty.covariance import residual, residuals_by_quantity
from mechid.identification.uncertainty.settings import NOISE
from mechid.signal import effective_samples
from mechid.signal.autoregression import fit_autoregression
from mechid.signal.moments import norm
from mechid.signal.series import Series, is_finite
from mechid.signal.spikes import isolated_spikes, outliers
from mechid.signal.stored import map_samples, samples_at, write_at
from mechid.units import unit_words


def release_noise(
    problem: Problem, q: FloatArray, windows: Windows, options: IdentifyOptions
) -> tuple[Problem, tuple[str, ...]]:
    """Return the problem with the residual RMS of each record's channels as their sigma, and a line for each misfit.

    A channel whose residual is more than 1.2 times its own noise floor keeps the floor, so that it is not
    weighted away, unless the search has raised its level already. A coloured residual is whitened from here on, as the
    options want it; one that is mainly rounding, or whose level was raised, only where they ask for it.
    No sigma falls below that of the resolution that is declared: a standstill tells nothing of what is within it.
    """
    said: list[str] = []

    def one(target: Target) -> Target:
        window = windows[target.name]
        series = residuals_by_quantity(problem, target, q, window)
        said.extend(
            filter(None, (_misfit_line(target, c, _rms(c, series[c.quantity], window)) for c in target.channels))
        )
        return target.each(lambda channel: _released(channel, series[channel.quantity], window, options))

    targets = tuple(one(t) if t.name in windows else t for t in problem.targets)
    return replace(problem, targets=targets), tuple(said)


def _rms(channel: TargetChannel, r: Series, window: tuple[int, int]) -> float:
    """Return the RMS of a residual over the samples that count."""
    rejected = channel.rejected_within(window).size
    return norm(r) / math.sqrt(float(max(r.size - rejected, 1)))


def _misfit_line(target: Target, channel: TargetChannel, rms: float) -> str:
    """Say that a channel's residual is no noise of its level; nothing where it is."""
    if _is_noise(channel, rms):
        return ""
    unit, alone = unit_words(channel.quantity), len(target.channels) == 1
    what, whose = ("", "record's") if alone else (f" of {channel.quantity}", "channel's")
    return (
        f"record {target.name}: the residual{what} is {rms:.3g} {unit} RMS, {rms / channel.sigma:.2f} times the "
        f"{whose} noise floor {channel.sigma:.3g} {unit}: the model lacks something that this record contains, or "
        "its noise is coloured"
    )


def _released(channel: TargetChannel, r: Series, window: tuple[int, int], options: IdentifyOptions) -> TargetChannel:
    """Return a channel with the level, and as the options want it the colour, of its residual as its noise."""
    rms = _rms(channel, r, window)
    fits = _is_noise(channel, rms)
    found = replace(channel, sigma=max(rms, channel.rounding, SMALLEST)) if fits else channel
    own = fits and not channel.raised and found.rounded <= NOISE.mostly_rounding
    if options.colour == "none" or (options.colour == "auto" and not own):
        return found
    colour = fit_autoregression(r, rejected=channel.rejected_within(window))
    return replace(found, prefilter=colour) if colour.order else found


def _is_noise(channel: TargetChannel, rms: float) -> bool:
    """Tell whether a residual counts as noise: of its channel's level, or that of a channel whose level was raised."""
    return rms <= NOISE.misfit * channel.sigma or channel.raised > 0.0


def whiten_again(problem: Problem, q: FloatArray, windows: Windows) -> Problem:
    """Return the problem with prefilters of what `q` leaves; the same one where none is much better than before.

    Before the first whitening the estimates err by what the colour costs, and that is in the residual too.
    """
    return each_target(problem, lambda t: _whitened_again(problem, t, q, windows[t.name]) if t.name in windows else t)


def each_target(problem: Problem, change: Callable[[Target], Target]) -> Problem:
    """Return the problem with every target changed; the same one where none is."""
    targets = tuple(map(change, problem.targets))
    unchanged = all(a is b for a, b in zip(targets, problem.targets, strict=True))
    return problem if unchanged else replace(problem, targets=targets)


def _whitened_again(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]) -> Target:
    if not any(c.prefilter for c in target.channels):
        return target
    series = residual(problem, target, q, window)
    found = [
        replace(c, prefilter=fit_autoregression(r, rejected=c.rejected_within(window))) if c.prefilter else c
        for c, r in zip(target.channels, series, strict=True)
    ]
    quieter = any(
        new.prefilter.sigma < NOISE.quieter * old.prefilter.sigma
        for old, new in zip(target.channels, found, strict=True)
        if old.prefilter and new.prefilter
    )
    return replace(target, channels=tuple(found)) if quieter else target


def with_residual_levels(problem: Problem, q: FloatArray) -> Problem:
    """Return the problem with each misfit record at its own residual's RMS, to judge whether `q` follows it.

    One whose level was raised is such a record.

    What a model lacks is in the residual throughout: against the floor every stretch would count as lost. A coloured
    residual is worth fewer samples, so a short stretch of it scatters more: the RMS grows by what chance allows more.
    """
    return replace(problem, targets=tuple(_by_own_residual(problem, t, q) for t in problem.targets))


def _by_own_residual(problem: Problem, target: Target, q: FloatArray) -> Target:
    series = residuals_by_quantity(problem, target, q)
    window = gate_window(target)
    return target.each(lambda channel: _channel_by_own_residual(channel, series[channel.quantity], window))


def _channel_by_own_residual(channel: TargetChannel, r: Series, window: int) -> TargetChannel:
    if not is_finite(r):
        return channel
    rms = _rms(channel, r, (0, r.size))
    if rms <= NOISE.misfit * channel.sigma and channel.prefilter is None and not channel.raised:
        return channel
    worth = max(window * effective_samples(r) / r.size, 1.0)
    return replace(channel, sigma=rms * math.sqrt(chance_limit_of(worth) / chance_limit_of(window)))


def with_levels_of_residuals(problem: Problem, target: Target, q: FloatArray) -> Target:
    """Return a target with no channel's sigma below the RMS of its residual at `q`."""
    series = residuals_by_quantity(problem, target, q)

    def own(channel: TargetChannel) -> TargetChannel:
        return replace(channel, sigma=max(channel.sigma, _rms(channel, series[channel.quantity], (0, target.samples))))

    return target.each(own)


def without_spikes(target: Target) -> Target:
    """Return a target without single samples far off their neighbours, which are bridged for the search."""
    return target.each(_without_spikes)


def _without_spikes(channel: TargetChannel) -> TargetChannel:
    spikes = isolated_spikes(channel.measured, channel.sigma)
    if not spikes.size:
        return channel
    measured = map_samples(channel.measured, lambda values, part: values.copy())
    beside = np.setdiff1d(np.concatenate((spikes - 1, spikes + 1)), spikes)
    beside = beside[(beside >= 0) & (beside < measured.size)]
    write_at(measured, spikes, np.interp(spikes, beside, samples_at(measured, beside)))
    return replace(channel, measured=measured, rejected=np.union1d(channel.rejected, spikes))


def without_outliers(problem: Problem, q: FloatArray, windows: Windows) -> Problem:
    """Return the problem without the samples that a fit has shown to be far off; the same where there are none."""
    return each_target(problem, lambda t: _without_outliers(problem, t, q, windows.get(t.name)))


def _without_outliers(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int] | None) -> Target:
    if window is None:
        return target
    series = residuals_by_quantity(problem, target, q, window)

    def kept(channel: TargetChannel) -> TargetChannel:
        new = outliers(series[channel.quantity], NOISE.far_off) + window[0]
        if not 0 < new.size <= NOISE.most_rejected * target.samples:
            return channel
        return replace(channel, rejected=np.union1d(channel.rejected, new))

    return target.each(kept)


def rejection_warnings(problem: Problem) -> list[str]:
    """Say how many samples of each record do not count, and where the first are."""
    lines = []
    for t in problem.targets:
        for c in t.channels:
            spikes = np.setdiff1d(np.setdiff1d(c.rejected, c.bridged), c.masked)
            if not spikes.size:
                continue
            instants = ", ".join(f"{t.base.start_s + k / t.base.sample_rate_hz:.6g}" for k in spikes[:5].tolist())
            more = ", ..." if spikes.size > 5 else ""
            what = "samples" if len(t.channels) == 1 else f"samples of {c.quantity}"
            lines.append(f"record {t.name}: {spikes.size} {what} rejected as spikes, at {instants}{more} s")
    return lines
