"""Noise level of each record's channels: held at its floor during the search, set from the residual at the end."""

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
from mechid.signal.stored_series import map_samples, samples_at, write_at
from mechid.units import unit_words


def release_noise(
    problem: Problem, q: FloatArray, windows: Windows, options: IdentifyOptions
) -> tuple[Problem, tuple[str, ...]]:
    """Set each channel's sigma to its residual RMS; also return a line for each channel that the model does not fit.

    A channel whose residual exceeds 1.2 times its noise floor keeps the floor, so that its weight does not vanish,
    unless the search has raised its level already. A coloured residual is whitened from here on, as the options
    request. One that is mainly rounding, or whose level was raised, is whitened only on explicit request.
    No sigma falls below that of the declared resolution: a standstill shows nothing of the motion within one step.
    """
    said: list[str] = []

    def one(target: Target) -> Target:
        window = windows[target.name]
        series = residuals_by_quantity(problem, target, q, window)
        said.extend(
            filter(None, (_misfit_line(target, c, _rms(c, series[c.quantity], window)) for c in target.channels))
        )
        return target.map_channels(lambda channel: _release_channel(channel, series[channel.quantity], window, options))

    targets = tuple(one(t) if t.name in windows else t for t in problem.targets)
    return replace(problem, targets=targets), tuple(said)


def _rms(channel: TargetChannel, r: Series, window: tuple[int, int]) -> float:
    """Return the RMS of a residual over the samples that are not rejected."""
    rejected = channel.rejected_within(window).size
    return norm(r) / math.sqrt(float(max(r.size - rejected, 1)))


def _misfit_line(target: Target, channel: TargetChannel, rms: float) -> str:
    """Report a residual that exceeds its channel's noise level; empty where it does not."""
    if _is_noise(channel, rms):
        return ""
    unit, alone = unit_words(channel.quantity), len(target.channels) == 1
    quantity, owner = ("", "record's") if alone else (f" of {channel.quantity}", "channel's")
    return (
        f"record {target.name}: the residual{quantity} is {rms:.3g} {unit} RMS, {rms / channel.sigma:.2f} times the "
        f"{owner} noise floor {channel.sigma:.3g} {unit}: the model lacks something that this record contains, or "
        "its noise is coloured"
    )


def _release_channel(
    channel: TargetChannel, r: Series, window: tuple[int, int], options: IdentifyOptions
) -> TargetChannel:
    """Set a channel's noise level, and its prefilter where the options request one, from its residual."""
    rms = _rms(channel, r, window)
    fits = _is_noise(channel, rms)
    found = replace(channel, sigma=max(rms, channel.rounding, SMALLEST)) if fits else channel
    # Rounding is not stationary, and a raised level covers a misfit: neither has a colour that a prefilter can model.
    stationary = fits and not channel.raised and found.rounding_share <= NOISE.mostly_rounding
    if options.colour == "none" or (options.colour == "auto" and not stationary):
        return found
    colour = fit_autoregression(r, rejected=channel.rejected_within(window))
    return replace(found, prefilter=colour) if colour.order else found


def _is_noise(channel: TargetChannel, rms: float) -> bool:
    """Tell whether a residual counts as noise: it is near its channel's level, or that level was raised."""
    return rms <= NOISE.misfit * channel.sigma or channel.raised > 0.0


def whiten_again(problem: Problem, q: FloatArray, windows: Windows) -> Problem:
    """Refit the prefilters to the residuals at `q`; return the same problem where none improves much.

    The first prefilters were fitted to residuals of an unwhitened estimate, which contain that estimate's larger error.
    """
    return change_each_target(
        problem, lambda t: _whiten_target_again(problem, t, q, windows[t.name]) if t.name in windows else t
    )


def change_each_target(problem: Problem, change: Callable[[Target], Target]) -> Problem:
    """Apply a change to every target; return the same problem where no target changes."""
    targets = tuple(map(change, problem.targets))
    unchanged = all(a is b for a, b in zip(targets, problem.targets, strict=True))
    return problem if unchanged else replace(problem, targets=targets)


def _whiten_target_again(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]) -> Target:
    if not any(c.prefilter for c in target.channels):
        return target
    series = residual(problem, target, q, window)
    found = [
        replace(c, prefilter=fit_autoregression(r, rejected=c.rejected_within(window))) if c.prefilter else c
        for c, r in zip(target.channels, series, strict=True)
    ]
    quieter = any(
        new.prefilter.sigma < NOISE.better_prefilter * old.prefilter.sigma
        for old, new in zip(target.channels, found, strict=True)
        if old.prefilter and new.prefilter
    )
    return replace(target, channels=tuple(found)) if quieter else target


def set_residual_levels(problem: Problem, q: FloatArray) -> Problem:
    """Set each misfit channel's level to its own residual's RMS, to judge whether `q` follows the record.

    A channel whose level was raised counts as a misfit.

    A model error is present throughout the residual: against the noise floor every stretch would count as lost. A
    coloured residual has fewer effective samples, so its short stretches scatter more; the RMS is scaled up by the
    ratio of the chance limits.
    """
    return replace(problem, targets=tuple(_set_target_levels(problem, t, q) for t in problem.targets))


def _set_target_levels(problem: Problem, target: Target, q: FloatArray) -> Target:
    series = residuals_by_quantity(problem, target, q)
    window = gate_window(target)
    return target.map_channels(lambda channel: _set_channel_level(channel, series[channel.quantity], window))


def _set_channel_level(channel: TargetChannel, r: Series, window: int) -> TargetChannel:
    if not is_finite(r):
        return channel
    rms = _rms(channel, r, (0, r.size))
    if rms <= NOISE.misfit * channel.sigma and channel.prefilter is None and not channel.raised:
        return channel
    effective = max(window * effective_samples(r) / r.size, 1.0)
    return replace(channel, sigma=rms * math.sqrt(chance_limit_of(effective) / chance_limit_of(window)))


def raise_to_residual_levels(problem: Problem, target: Target, q: FloatArray) -> Target:
    """Raise each channel's sigma to at least the RMS of its residual at `q`."""
    series = residuals_by_quantity(problem, target, q)

    def raise_sigma(channel: TargetChannel) -> TargetChannel:
        return replace(channel, sigma=max(channel.sigma, _rms(channel, series[channel.quantity], (0, target.samples))))

    return target.map_channels(raise_sigma)


def reject_spikes(target: Target) -> Target:
    """Reject isolated spikes of a target, and interpolate over them for the search."""
    return target.map_channels(_reject_channel_spikes)


def _reject_channel_spikes(channel: TargetChannel) -> TargetChannel:
    spikes = isolated_spikes(channel.measured, channel.sigma)
    if not spikes.size:
        return channel
    # The series belongs to the record; only a copy may be changed.
    measured = map_samples(channel.measured, lambda values, part: values.copy())
    beside = np.setdiff1d(np.concatenate((spikes - 1, spikes + 1)), spikes)
    beside = beside[(beside >= 0) & (beside < measured.size)]
    write_at(measured, spikes, np.interp(spikes, beside, samples_at(measured, beside)))
    return replace(channel, measured=measured, rejected=np.union1d(channel.rejected, spikes))


def reject_outliers(problem: Problem, q: FloatArray, windows: Windows) -> Problem:
    """Reject the outliers of the residuals at `q`; return the same problem where there are none."""
    return change_each_target(problem, lambda t: _reject_target_outliers(problem, t, q, windows.get(t.name)))


def _reject_target_outliers(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int] | None) -> Target:
    if window is None:
        return target
    series = residuals_by_quantity(problem, target, q, window)

    def reject_outliers(channel: TargetChannel) -> TargetChannel:
        new = outliers(series[channel.quantity], NOISE.spike_deviations) + window[0]
        # So many distant samples are a misfit of the model, not spikes of the instrument.
        if not 0 < new.size <= NOISE.most_rejected * target.samples:
            return channel
        return replace(channel, rejected=np.union1d(channel.rejected, new))

    return target.map_channels(reject_outliers)


def rejection_warnings(problem: Problem) -> list[str]:
    """Report the number of rejected samples of each record, with the first instants."""
    lines = []
    for t in problem.targets:
        for c in t.channels:
            spikes = np.setdiff1d(np.setdiff1d(c.rejected, c.bridged), c.masked)
            if not spikes.size:
                continue
            instants = ", ".join(f"{t.base.start_s + k / t.base.sample_rate_hz:.6g}" for k in spikes[:5].tolist())
            more = ", ..." if spikes.size > 5 else ""
            samples = "samples" if len(t.channels) == 1 else f"samples of {c.quantity}"
            lines.append(f"record {t.name}: {spikes.size} {samples} rejected as spikes, at {instants}{more} s")
    return lines
