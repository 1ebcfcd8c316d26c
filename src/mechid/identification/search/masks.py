"""Masks of single windows of misfit: moments that the model does not follow, between stretches that it does.

A knock on the bench, or a stick-slip event that flips for a moment, stops the growth although the model follows the
record after it. Such a moment is masked: its samples are rejected, as spikes are. Masks are for single moments only. A
misfit that recurs, lasts longer or appears in many records is a deficiency of the model, and is not masked.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from mechid.arrays import FloatArray, IntArray
from mechid.identification.computation.journal import Journal
from mechid.identification.output_error.misfit import misfit_series
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.identification.search.first_moments import Horizons
from mechid.identification.search.gates import Growth, grow_horizons
from mechid.identification.search.horizons import chance_limit_of, followed_samples, gate_window, least_horizons
from mechid.identification.search.settings import SEARCH
from mechid.signal.runs import Runs, runs_of, samples_of


def grow_past_misfit(
    problem: Problem,
    growth: Growth,
    rng: np.random.Generator,
    progress: Callable[[FloatArray, Horizons], None] = lambda q, gates: None,
    *,
    journal: Journal | None = None,
) -> tuple[Problem, Growth] | None:
    """Mask single windows of misfit and grow; return the masked problem and a growth that follows all records.

    None if a few masks do not achieve this.

    Parameters
    ----------
    problem : Problem
    growth : Growth
        A growth that has stalled.
    rng, progress, journal
        As for `grow_horizons`.
    """
    for _ in range(SEARCH.mask_rounds):
        masked = _mask_stalls(problem, growth.q)
        if masked is problem:
            return None
        growth = grow_horizons(masked, growth.q, rng, progress, escapes=0, leaps=SEARCH.mask_leaps, journal=journal)
        # Moments that were off only because the values were are followed now; they must not use up allowed masks.
        problem = lift_followed_masks(masked, growth.q)
        if not is_rare(problem):
            return None
        if growth.complete:
            return problem, growth
    return None


def mask_near(problem: Problem, q: FloatArray, rng: np.random.Generator) -> tuple[Problem, FloatArray]:
    """Mask the single moments that a trusted point does not follow; return the problem and the point of the growth.

    Both are returned unchanged if the point follows all records, or if a few masks do not suffice.
    """
    followed = {t.name: followed_samples(problem, t, q) for t in problem.targets}
    if all(followed[t.name] == t.samples for t in problem.targets):
        return problem, q
    found = grow_past_misfit(problem, Growth(q, followed, False, 0), rng)
    return (found[0], found[1].q) if found and masked_runs(found[0]) else (problem, q)


def _mask_stalls(problem: Problem, q: FloatArray) -> Problem:
    """Mask the moment at which each record stops being followed; return the same problem if none can be masked."""
    least = least_horizons(problem)
    targets = tuple(_mask_stall(problem, t, q, least[t.name]) for t in problem.targets)
    unchanged = all(a is b for a, b in zip(targets, problem.targets, strict=True))
    return problem if unchanged else replace(problem, targets=targets)


def _mask_stall(problem: Problem, target: Target, q: FloatArray, least: int) -> Target:
    """Mask the moment at which a target stops being followed, and one window on either side.

    The same target is returned if the model does not follow the data after that moment, or has not begun to follow the
    record.
    """
    followed = followed_samples(problem, target, q)
    if not least <= followed < target.samples:
        return target
    window = gate_window(target)
    first = followed // window
    for stop in range(first + 1, first + 1 + SEARCH.mask_windows):
        behind = (stop + SEARCH.mask_behind) * window
        if behind > target.samples:
            break
        alone = mask_samples(target, np.arange(first * window, stop * window))
        if followed_samples(problem, alone, q) >= behind:
            return mask_samples(target, np.arange(max(first - 1, 0) * window, (stop + 1) * window))
    return target


def is_rare(problem: Problem) -> bool:
    """Tell whether the masks are few, short and in few of the records, as those of single moments are."""
    runs = [(t, runs_of(t.leading.masked)) for t in problem.targets if t.leading.masked.size]
    # Masks in the majority of the records show a deficiency of the model. A single record may always have some.
    few_records = len(runs) <= max((len(problem.targets) - 1) // 2, 1)
    return few_records and all(_are_rare(target, own) for target, own in runs)


def _are_rare(target: Target, runs: Runs) -> bool:
    longest = (SEARCH.mask_windows + 2) * gate_window(target)
    share = sum(stop - first for first, stop in runs) / target.samples
    return (
        len(runs) <= SEARCH.mask_runs
        and all(stop - first <= longest for first, stop in runs)
        and (len(runs) == 1 or share <= SEARCH.mask_share)
    )


def lift_followed_masks(problem: Problem, q: FloatArray) -> Problem:
    """Lift the masks of moments that `q` follows; return the same problem if there are none."""
    targets = tuple(_lift_followed(problem, t, q) if t.leading.masked.size else t for t in problem.targets)
    unchanged = all(a is b for a, b in zip(targets, problem.targets, strict=True))
    return problem if unchanged else replace(problem, targets=targets)


def _lift_followed(problem: Problem, target: Target, q: FloatArray) -> Target:
    series = misfit_series(problem.model, target, q, (0, target.samples))
    off = [(channel, channel.line(r, channel.rejected), r) for channel, r in zip(target.channels, series, strict=True)]
    window = gate_window(target)

    def is_followed(first: int, stop: int) -> bool:
        return all(
            _is_noise(channel, (r[first:stop] - line.at(first, stop)) / channel.sigma, window)
            for channel, line, r in off
        )

    followed = [run for run in runs_of(target.leading.masked) if is_followed(*run)]
    return _lift(target, samples_of(followed)) if followed else target


def _is_noise(channel: TargetChannel, r: FloatArray, window: int) -> bool:
    """Tell whether no window of a residual, (n,) in sigmas, has a mean square beyond chance."""
    limit = max(chance_limit_of(window), SEARCH.gate_limit * (channel.rounding / channel.sigma) ** 2)
    windows = r[: r.size // window * window].reshape(-1, window)
    return bool(np.all(np.isfinite(r)) and np.all(np.mean(windows**2, axis=1) <= limit))


def mask_samples(target: Target, samples: IntArray) -> Target:
    """Return a target with some samples rejected in all channels and marked as masked."""

    def mask(channel: TargetChannel) -> TargetChannel:
        rejected, own = np.union1d(channel.rejected, samples), np.union1d(channel.masked, samples)
        return replace(channel, rejected=rejected, masked=own)

    return target.map_channels(mask) if samples.size else target


def _lift(target: Target, samples: IntArray) -> Target:
    """Return a target in which masked samples count again, except those that were never measured."""

    def lift(channel: TargetChannel) -> TargetChannel:
        rejected = np.setdiff1d(channel.rejected, np.setdiff1d(samples, channel.bridged))
        return replace(channel, rejected=rejected, masked=np.setdiff1d(channel.masked, samples))

    return target.map_channels(lift)


def masked_runs(problem: Problem) -> dict[str, Runs]:
    """Return the runs of masked samples by record name, without unmasked records."""
    return {t.name: runs_of(t.leading.masked) for t in problem.targets if t.leading.masked.size}


def apply_masks(problem: Problem, masks: Mapping[str, Sequence[Sequence[int]]]) -> Problem:
    """Mask runs of samples by record; return the same problem if there are no masks."""
    if not any(masks.values()):
        return problem
    targets = tuple(mask_samples(t, samples_of(masks.get(t.name, ()))) for t in problem.targets)
    return replace(problem, targets=targets)
