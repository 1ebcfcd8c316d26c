"""Hints in words about the point where a model stops following a record: events there, and the misfit's frequency."""

from __future__ import annotations

import numpy as np

from mechid.arrays import FloatArray
from mechid.command import MeasuredCommand
from mechid.command.edges import steps_travelled
from mechid.identification.output_error.misfit import misfit_series
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.search.settings import SEARCH
from mechid.identification.stages.settings import STAGES
from mechid.signal.spectrum import amplitude_spectrum
from mechid.signal.trend import fit_line
from mechid.simulation.resonances import resonances


def departure(problem: Problem, q: FloatArray, target: Target, horizon: int) -> str:
    """Return a description, in one or more clauses, of the point where the model leaves a record.

    It names the commanded rate after `horizon` samples, a nearby stick-slip event of the model, and the misfit's
    frequency relative to the step rate and the detents. It describes the residual near that point and tests no
    hypothesis.
    """
    base, timing = target.base, problem.coordinates.timing(target, q)
    at_s = timing.command_s(base.start_s + horizon / base.sample_rate_hz)
    rate = _rate(target, at_s)
    driven = isinstance(target.command, MeasuredCommand)
    said = ["its input channels drive it there"] if driven else [f"the command runs at {rate:.4g} steps/s there"]
    switch = _switch(problem, q, target, horizon)
    if switch:
        said.append(switch)
    line = _line(problem, q, target, horizon, rate) if rate > 0.0 else ""
    return "; ".join([*said, line] if line else said)


def _rate(target: Target, at_s: float) -> float:
    """Return the magnitude of the commanded rate at an instant of command time, full steps/s."""
    # A finite difference of the travelled steps holds for any profile, also at its kinks.
    around = np.array([max(at_s - 5e-4, 0.0), max(at_s, 0.0) + 5e-4])
    travelled = steps_travelled(target.command.rate, around)
    return float(np.diff(travelled)[0] / np.diff(around)[0])


def _switch(problem: Problem, q: FloatArray, target: Target, horizon: int) -> str:
    """Return a clause about the model's stick-slip event nearest to the horizon, within 5 ms; or nothing."""
    base, timing = target.base, problem.coordinates.timing(target, q)
    past = horizon + round(SEARCH.gate_window_s * base.sample_rate_hz)
    run = problem.model.run(target, q, past, events=STAGES.most_switches)
    for _ in run.blocks():
        pass
    plant, switching = problem.space.mechanism.plant, run.switching
    at_s = timing.command_s(base.start_s + horizon / base.sample_rate_hz)
    near = np.flatnonzero(np.abs(switching.time - at_s) < SEARCH.gate_window_s)
    if not near.size:
        return ""
    k = near[np.argmin(np.abs(switching.time[near] - at_s))]
    modes = list(plant.switches[int(switching.switch[k])].modes)
    before, after = modes[int(switching.before[k])], modes[int(switching.after[k])]
    return (
        f"the model's {plant.switches[int(switching.switch[k])].name} goes from {before} to {after} at "
        f"{timing.record_s(switching.time[k]):.4g} s, which the record may not have"
    )


def _line(problem: Problem, q: FloatArray, target: Target, horizon: int, rate: float) -> str:
    """Return a clause about the largest misfit frequency and its likely cause; or nothing.

    The frequency is given as a multiple of the step rate.
    """
    reach = round(STAGES.stretch_steps / rate * target.base.sample_rate_hz)
    window = max(horizon - reach, 0), min(horizon + reach, target.samples)
    r = misfit_series(problem.model, target, q, window)[0][:]
    if r.size < 2 or not np.all(np.isfinite(r)):
        return ""
    fit_line(r, 2).subtract_from(r)
    # The taper keeps side lobes of a strong line from passing for lines of their own.
    tapered = np.concatenate([r * np.hanning(r.size), np.zeros((STAGES.padded - 1) * r.size)])
    frequency, amplitude = amplitude_spectrum(tapered, target.base.sample_rate_hz)
    # Two bins from zero, the taper mixes a line with the mean.
    tellable = (frequency > 2.0 * target.base.sample_rate_hz / r.size) & (frequency < 10.0 * rate)
    if not tellable.any():
        return ""
    width_hz = target.base.sample_rate_hz / r.size
    swinging = resonances(problem.space.at(q[: problem.space.size]))
    least = max(
        STAGES.stands_out * float(np.median(amplitude[tellable])), STAGES.line_share * float(amplitude[tellable].max())
    )
    peaks = [k for k in _peaks(amplitude) if tellable[k] and amplitude[k] > least]
    said: dict[str, str] = {}
    for k in sorted(peaks, key=lambda k: -amplitude[k])[:2]:
        near = next((r.name for r in swinging if abs(frequency[k] - r.frequency_hz) < 2.0 * width_hz), "")
        owner = f", which is near the resonance of the {near}" if near else ""
        owner = owner or _owner(problem, float(frequency[k]) / rate, width_hz / rate)
        said.setdefault(owner or str(k), f"{frequency[k] / rate:.3g} times the step rate{owner}")
    at_s = target.base.start_s + horizon / target.base.sample_rate_hz
    return f"the misfit around {at_s:.4g} s oscillates at {' and at '.join(said.values())}" if said else ""


def _peaks(y: FloatArray) -> list[int]:
    """Return the indices of local maxima."""
    above = (y[1:-1] > y[:-2]) & (y[1:-1] > y[2:])
    return (1 + np.flatnonzero(above)).tolist()


def _owner(problem: Problem, order: float, width: float) -> str:
    """Return a clause about the cause of a line at a multiple of the step rate; or nothing.

    The cause may be a harmonic of the model, or a detent that the model lacks.
    """
    mechanism = problem.space.mechanism
    # In an electrical period a detent has as many periods as its order.
    cycle = float(mechanism.full_steps)
    for own in mechanism.harmonics:
        if abs(order - own.orders / cycle) < width:
            steps = " and of the steps" if own.orders == cycle else ""
            return f", the period of its {own.words} of {own.period_deg:.4g} deg{steps}"
    nearest = max(round(order * cycle), 1)
    if mechanism.electrical_periods and abs(order - nearest / cycle) < width and nearest < cycle:
        period_deg = 360.0 / mechanism.electrical_periods / nearest
        return f", the period of a detent of {period_deg:.4g} deg, which the model has not"
    return ""
