"""Noise of each record: held at its high-frequency floor during the search, released at the end."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mechid.campaign.identify_options import IdentifyOptions
from mechid.identification.gates import chance_of, gate_window
from mechid.identification.problem import Problem, Target, Windows
from mechid.identification.uncertainty import residual
from mechid.signal import effective_samples
from mechid.signal.autoregression import fit_autoregression
from mechid.signal.spikes import isolated_spikes, outliers

FloatArray = NDArray[np.float64]
MISFIT = 1.2
FAR_OFF = 6.0
"""Robust standard deviations from which a sample of the residual is a spike; noise gets there once in 5e8."""
MOST_REJECTED = 0.01
"""Share of a record beyond which what is far off is no spike."""


def released(problem: Problem, q: FloatArray, windows: Windows, options: IdentifyOptions, said: list[str]) -> Problem:
    """Return the problem with each record's residual RMS as its sigma, unless that is a misfit.

    A record whose residual is more than 1.2 times its own noise floor keeps the floor, so that it is not
    weighted away, and `said` gets a line. A coloured residual is whitened from here on, as the options want it.
    """
    targets = [
        _released(problem, t, q, windows[t.name], options, said) if t.name in windows else t for t in problem.targets
    ]
    return replace(problem, targets=tuple(targets))


def _released(
    problem: Problem, target: Target, q: FloatArray, window: tuple[int, int], options: IdentifyOptions, said: list[str]
) -> Target:
    r = residual(problem, target, q, window)
    rejected = int(np.sum((target.rejected >= window[0]) & (target.rejected < window[1])))
    rms = float(np.linalg.norm(r)) / math.sqrt(float(max(r.size - rejected, 1)))
    fits = rms <= MISFIT * target.sigma
    if not fits:
        said.append(
            f"record {target.name}: the residual is {rms:.3g} N m RMS, {rms / target.sigma:.2f} times the record's "
            f"noise floor {target.sigma:.3g} N m: the model lacks something that this record contains, or its noise "
            "is coloured"
        )
    found = replace(target, sigma=rms) if fits else target
    if options.colour == "none" or (options.colour == "auto" and not fits):
        return found
    colour = fit_autoregression(r)
    return replace(found, prefilter=colour) if colour.order else found


def by_own_residuals(problem: Problem, q: FloatArray) -> Problem:
    """Return the problem with each misfit record at its own residual's RMS, to judge whether `q` follows it.

    What a model lacks is in the residual throughout: against the floor every stretch would count as lost. A coloured
    residual is worth fewer samples, so a short stretch of it scatters more: the RMS grows by what chance allows more.
    """
    return replace(problem, targets=tuple(_by_own_residual(problem, t, q) for t in problem.targets))


def _by_own_residual(problem: Problem, target: Target, q: FloatArray) -> Target:
    r = residual(problem, target, q, (0, target.samples))
    if not np.all(np.isfinite(r)):
        return target
    rms = float(np.linalg.norm(r)) / math.sqrt(r.size)
    if rms <= MISFIT * target.sigma and target.prefilter is None:
        return target
    window = gate_window(target)
    worth = max(window * effective_samples(r) / r.size, 1.0)
    return replace(target, sigma=rms * math.sqrt(chance_of(worth) / chance_of(window)))


def without_spikes(target: Target) -> Target:
    """Return a target without single samples far off their neighbours, which are bridged for the search."""
    spikes = isolated_spikes(target.measured, target.sigma)
    if not spikes.size:
        return target
    kept = np.delete(np.arange(target.samples), spikes)
    measured = target.measured.copy()
    measured[spikes] = np.interp(spikes, kept, target.measured[kept])
    return replace(target, measured=measured, rejected=spikes)


def without_outliers(problem: Problem, q: FloatArray, windows: Windows) -> Problem:
    """Return the problem without the samples that a fit has shown to be far off; the same where there are none."""
    targets = tuple(_without_outliers(problem, t, q, windows.get(t.name)) for t in problem.targets)
    unchanged = all(a is b for a, b in zip(targets, problem.targets, strict=True))
    return problem if unchanged else replace(problem, targets=targets)


def _without_outliers(problem: Problem, target: Target, q: FloatArray, window: tuple[int, int] | None) -> Target:
    if window is None:
        return target
    new = outliers(residual(problem, target, q, window), FAR_OFF) + window[0]
    if not 0 < new.size <= MOST_REJECTED * target.samples:
        return target
    return replace(target, rejected=np.union1d(target.rejected, new))


def rejection_warnings(problem: Problem) -> list[str]:
    """Say how many samples of each record do not count, and where the first are."""
    lines = []
    for t in problem.targets:
        if t.rejected.size:
            instants = ", ".join(f"{t.base.start_s + k / t.base.sample_rate_hz:.6g}" for k in t.rejected[:5].tolist())
            more = ", ..." if t.rejected.size > 5 else ""
            lines.append(f"record {t.name}: {t.rejected.size} samples rejected as spikes, at {instants}{more} s")
    return lines
