"""A noise level lowered to what a model leaves: the high frequencies of a record are not all noise.

Impacts, as of teeth in a gear with backlash, fill the spectrum up to the Nyquist frequency, and a level read there may
be twice that of the noise. Inside it a wrong branch, and an effect that is missing, look like noise. What a model
leaves of a stretch that it follows holds all of the noise, so that no level stands above it.
"""

from __future__ import annotations

import math
from dataclasses import replace

from mechid.arrays import FloatArray
from mechid.identification.output_error.noise_level import NoiseSource
from mechid.identification.output_error.problem import Problem, Windows
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.identification.uncertainty.covariance import residual
from mechid.identification.uncertainty.settings import NOISE
from mechid.signal.moments import norm
from mechid.signal.noise import FLOOR_ERROR
from mechid.signal.series import Series


def lowered(problem: Problem, q: FloatArray, windows: Windows) -> Problem:
    """Return the problem with no level above what `q` leaves in the windows; the same one where none is clearly above.

    A level that rests on more than high frequencies stays, and none falls below that of the resolution.
    """
    targets = tuple(_lowered(problem, t, q, windows[t.name]) if t.name in windows else t for t in problem.targets)
    changed = any(a is not b for a, b in zip(targets, problem.targets, strict=True))
    return replace(problem, targets=targets) if changed else problem


def _lowered(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int]) -> Target:
    series = dict(zip(target.quantities, residual(problem, target, q, window), strict=True))
    return target.each(lambda channel: _at_most(channel, series[channel.quantity], window))


def _at_most(channel: TargetChannel, r: Series, window: tuple[int, int]) -> TargetChannel:
    counted = r.size - channel.rejected_within(window).size
    if channel.rests_on is not NoiseSource.FLOOR or channel.prefilter or counted < NOISE.least_samples:
        return channel
    level = max(norm(r) / math.sqrt(counted), channel.rounding)
    clearly = 1.0 - NOISE.sure * math.hypot(FLOOR_ERROR, math.sqrt(0.5)) / math.sqrt(counted)
    return replace(channel, sigma=level) if level < clearly * channel.sigma else channel


def levels_of(problem: Problem) -> dict[tuple[str, str], float]:
    """Return the noise level of each record's channels, by record and quantity, SI."""
    return {(t.name, c.quantity): c.sigma for t in problem.targets for c in t.channels}


def at_these_levels(problem: Problem, other: Problem) -> Problem:
    """Return a problem with the levels of another one of the same records and channels."""
    known = levels_of(other)

    def one(target: Target) -> Target:
        return target.each(lambda c: replace(c, sigma=known.get((target.name, c.quantity), c.sigma)))

    return replace(problem, targets=tuple(map(one, problem.targets)))
