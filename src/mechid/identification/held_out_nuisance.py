"""Fit of a held-out record's own parameters on its first part, with the mechanism held at the estimate.

A time offset, a gain or a supply voltage that a held-out record declares as free does not concern the mechanism, and no
fitted record shows it. At the file's value, its error would be counted as an error of the mechanism.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.campaign import Campaign, CampaignRecord
from mechid.command import MeasuredCommand
from mechid.command.edges import steps_travelled
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import Target, is_time_offset, target_of
from mechid.identification.result.fit import Fit
from mechid.identification.result.grade import FitOutcome
from mechid.identification.result.missing_effects import EffectValue
from mechid.identification.result.record_fit import channel_noises, record_fit
from mechid.identification.result.record_result import Nuisance, RecordFit
from mechid.identification.result.search_state import SearchState
from mechid.identification.result.settings import HELD_OUT
from mechid.identification.search.first_moments import run_up
from mechid.identification.search.solve import solve
from mechid.identification.uncertainty.covariance import residuals_by_quantity, uncertainty
from mechid.identification.uncertainty.noise import reject_spikes
from mechid.identification.uncertainty.verdict import seen_coordinates
from mechid.signal.moments import norm
from mechid.signal.series import blocks


def fit_held_out_records(fit: Fit, campaign: Campaign, state: SearchState) -> Fit:
    """Fit the own parameters of held-out records on their first parts.

    Parameters
    ----------
    fit : Fit
    campaign : Campaign
        Campaign with the records as the fit read them.
    state : SearchState
        State at the end of the search, with the final noise levels and the priors.

    Returns
    -------
    Fit
        Fit whose held-out records are predicted with these values, over the rest of the record. Its notes list the
        values, its warnings the parameters that the first part does not determine.
    """
    records, notes, warnings = dict(fit.records), list(fit.notes), list(fit.warnings)
    for record in (r for r in campaign.validated if r.data is not None and r.name in records):
        known = record.with_known_values({name: p.value for name, p in fit.parameters.items()})
        if not any(q.is_free for q in known.parameters):
            continue
        if fit.outcome in (FitOutcome.FAILED, FitOutcome.INTERRUPTED):
            warnings.append(f"record {record.name}: held out, and predicted at the start values of its table")
            continue
        found = _fit_first_part(known, fit, campaign, state)
        records[record.name] = _judge_rest(known, found, fit, state)
        notes.append(_note(record.name, found))
        warnings += _doubts(known, found)
    return replace(fit, records=records, notes=tuple(notes), warnings=tuple(warnings))


def first_part(record: CampaignRecord, target: Target) -> int:
    """Return the samples of the first part of a record: a tenth of its motion, and 16 full steps at least.

    It depends on the record and its command alone, so that all fits are judged by the same rest. At least half of the
    record remains for that.
    """
    n = target.samples
    begins, enough = _measured_motion(target) if isinstance(record.command, MeasuredCommand) else _step_samples(target)
    stop = max(begins + math.ceil(HELD_OUT.first_share * (n - begins)), enough, target.burn_in + 1)
    return max(min(stop, math.floor(HELD_OUT.largest_share * n)), 1)


def _step_samples(target: Target) -> tuple[int, int]:
    """Return the sample of the first step and that after enough steps, at the latest time offset of the command."""
    offset, base = target.time_offset, target.base
    times = base.start_s + np.linspace(0.0, base.duration_s, min(HELD_OUT.instants, base.samples))
    travelled = steps_travelled(target.command.rate, times - (offset.max if offset.is_free else offset.value))
    travelled -= travelled[0]
    places = np.searchsorted(travelled, [1e-9, HELD_OUT.first_steps]) / max(times.size - 1, 1) * (base.samples - 1)
    begins, enough = np.ceil(places).astype(int).tolist()
    return min(begins, base.samples), min(enough, base.samples)


def _measured_motion(target: Target) -> tuple[int, int]:
    """Return the sample at which a record under a measured input begins to move, twice."""
    y = target.leading.measured
    first = float(y[0:1][0])
    largest = max(float(np.max(np.abs(y[part] - first))) for part in blocks(y.size))
    for part in blocks(y.size):
        moving = np.flatnonzero(np.abs(y[part] - first) >= HELD_OUT.motion_share * largest)
        if moving.size:
            return (begins := part.start + int(moving[0])), begins
    return 0, 0


def _fit_first_part(record: CampaignRecord, fit: Fit, campaign: Campaign, state: SearchState) -> Nuisance:
    """Return the least-squares estimate of a record's own parameters on its first part."""
    problem, target = _problem(record, fit, campaign, state)
    windows = {target.name: (0, first_part(record, target))}
    solutions = [solve(problem, q, windows) for q in _starts(problem, target, windows[target.name])]
    best = min(solutions, key=lambda s: s.triangle.norm if np.isfinite(s.triangle.norm) else math.inf)
    q, (_, stop) = best.q, windows[target.name]
    if np.isfinite(best.triangle.norm):
        seen = seen_coordinates(problem, best.triangle)
        # A parameter without effect on the first part keeps the file's value.
        q = np.where(seen, q, problem.start)
        counted = seen & ~problem.coordinates.on_bound(q)
        variance = _noise_variances(problem, target, q, stop, counted) + _mechanism_variances(
            problem, target, q, stop, counted, fit
        )
        errors = np.where(counted, np.sqrt(variance), np.nan)
    else:
        q, errors = problem.start, np.full(q.size, np.nan)
    units = {p.name: p.declaration.unit for p in target.free_parameters}
    named = zip(problem.coordinates.record_parameter_names, q.tolist(), errors.tolist(), strict=True)
    own = {n: EffectValue(value=x, std_error=e if math.isfinite(e) else None, unit=units[n]) for n, x, e in named}
    return Nuisance(samples=stop, until_s=target.base.start_s + stop * target.base.interval_s, parameters=own)


def _problem(record: CampaignRecord, fit: Fit, campaign: Campaign, state: SearchState) -> tuple[Problem, Target]:
    """Return the problem of one record with the mechanism held, its channels at the noise levels of the fit."""
    noises = channel_noises(record, state.problem.targets)
    target = target_of(record)
    if campaign.options.spikes == "reject":
        target = reject_spikes(target)
    target = target.map_channels(lambda channel: replace(channel, sigma=noises[channel.quantity].found.sigma))
    wanted = () if campaign.options.priors == "none" else target.free_parameters
    priors = {p.name: (p.value, p.sigma) for p in wanted if p.sigma}
    space, was = SearchSpace(fit.mechanism.with_free(())), state.problem
    return Problem(space, (target,), priors, substeps=was.substeps, workers=was.workers), target


def _starts(problem: Problem, target: Target, window: tuple[int, int]) -> list[FloatArray]:
    """Return the start points: the file's values, and the best time offsets if the offset is free.

    The misfit over a time offset has a minimum for each period of an oscillation, so the nearest one is often not the
    deepest.
    """
    start = run_up(problem, problem.start)
    place = next((j for j, c in enumerate(problem.coordinates.own) if is_time_offset(c.parameter)), None)
    if place is None:
        return [start]
    low, high = float(problem.coordinates.lower[place]), float(problem.coordinates.upper[place])
    count = int(np.clip(math.ceil((high - low) / (2.0 * target.base.interval_s)) + 1, 5, HELD_OUT.most_offsets))
    apart = (high - low) / (count - 1)
    found = [start]
    for offset in _local_minima(problem, target, window, start, place, np.linspace(low, high, count))[
        : HELD_OUT.branches
    ]:
        about = np.clip(np.linspace(offset - apart, offset + apart, HELD_OUT.fine_offsets), low, high)
        fine = _local_minima(problem, target, window, start, place, about)[:1]
        found += [_set_offset(start, place, x) for x in fine]
    return found


def _local_minima(
    problem: Problem, target: Target, window: tuple[int, int], start: FloatArray, place: int, offsets: FloatArray
) -> list[float]:
    """Return the local minima of the misfit over the offsets, the lowest first."""
    points = [_set_offset(start, place, float(x)) for x in offsets]
    norms = np.array(problem.norms_at(target, points, window))
    # Infinite neighbours let the ends of the range be minima too.
    around = np.concatenate([[math.inf], np.where(np.isfinite(norms), norms, math.inf), [math.inf]])
    least = np.flatnonzero((around[1:-1] <= around[:-2]) & (around[1:-1] <= around[2:]) & np.isfinite(norms))
    return [float(offsets[k]) for k in least[np.argsort(norms[least], kind="stable")]]


def _set_offset(q: FloatArray, place: int, offset: float) -> FloatArray:
    out = q.copy()
    out[place] = offset
    return out


def _noise_variances(problem: Problem, target: Target, q: FloatArray, stop: int, counted: BoolArray) -> FloatArray:
    """Return variances by the first part's residual of any colour, (n,); 0 for coordinates that are not counted."""
    window = (0, stop)
    series = residuals_by_quantity(problem, target, q, window)
    # Noise is at least the residual's RMS: with the mechanism held, its errors are in the residual too.
    sizes = {c.quantity: norm(series[c.quantity]) / math.sqrt(stop) for c in target.channels}
    judged = target.map_channels(lambda channel: replace(channel, sigma=max(channel.sigma, sizes[channel.quantity])))
    problem = replace(problem, targets=(judged,))
    windows = {target.name: window}
    robust = uncertainty(problem, q, windows, problem.joint(q, windows), counted).robust
    return np.maximum(np.diag(robust), 0.0)


def _mechanism_variances(
    problem: Problem, target: Target, q: FloatArray, stop: int, counted: BoolArray, fit: Fit
) -> FloatArray:
    """Return variances by the errors of the held mechanism, which shift the fitted parameters, (n,)."""
    names = [name for name in fit.correlation_names if name in fit.mechanism.parameters]
    if not names or not counted.any():
        return np.zeros(q.size)
    space = SearchSpace(fit.mechanism.with_free(tuple(names)))
    moved = replace(problem, space=space)
    values, slopes = moved.coordinates.value_slopes(point := np.concatenate([space.start, q]))
    J = moved.triangle(moved.targets[0], point, (0, stop)).jacobian
    own = J[:, space.size :][:, counted]
    # Shift of the fitted parameters per unit error of each coordinate of the held mechanism.
    by_coordinate = -np.linalg.lstsq(own, J[:, : space.size], rcond=None)[0]
    by_value = by_coordinate @ np.linalg.pinv(slopes[: len(space.mechanism.free), : space.size])
    places = [fit.correlation_names.index(name) for name in values[: len(space.mechanism.free)]]
    variance = np.zeros(q.size)
    variance[counted] = np.diag(by_value @ fit.covariance[np.ix_(places, places)] @ by_value.T)
    return np.maximum(np.nan_to_num(variance), 0.0)


def _judge_rest(record: CampaignRecord, found: Nuisance, fit: Fit, state: SearchState) -> RecordFit:
    """Return the prediction of the rest of a record with the values fitted on its first part."""
    settled = record.with_known_values(found.values)
    problem = replace(state.problem, space=SearchSpace(fit.mechanism.with_free(())))
    target = target_of(settled)
    rest = {record.name: (found.samples, target.samples)}
    q = problem.coordinates.point({name: p.value for name, p in fit.parameters.items()})
    own = record_fit(settled, problem, q, rest)
    return replace(own, reading=fit.records[record.name].reading, nuisance=found)


def _note(record: str, found: Nuisance) -> str:
    """Describe the values fitted on the first part of a held-out record."""
    return (
        f"record {record}: held out; {', '.join(found.words())} fitted on its first part, up to {found.until_s:.4g} s, "
        "with the mechanism held; its figures are those of the rest"
    )


def _doubts(record: CampaignRecord, found: Nuisance) -> Iterator[str]:
    """Warn of parameters that the first part does not determine, or puts at a bound."""
    for q in (q for q in record.parameters if q.name in found.parameters):
        own = found.parameters[q.name]
        if own.std_error is not None:
            continue
        at_bound = min(abs(own.value - q.min), abs(own.value - q.max)) < 1e-6 * (q.max - q.min)
        reason = (
            f"lies at its bound {own.value:.6g} {q.declaration.unit}; give it a wider range"
            if at_bound
            else f"does not show in it; the value in the campaign file, {own.value:.6g} {q.declaration.unit}, is used"
        )
        yield f"{q.name}: fitted on the record's first part, up to {found.until_s:.4g} s, it {reason}"
