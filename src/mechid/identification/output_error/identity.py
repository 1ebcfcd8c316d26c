"""Identity of a problem: the inputs of the steps of a journal, as plain values."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

from mechid.identification.computation.journal import digest
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target, TargetChannel
from mechid.signal.stored import pieces_of


def identity(problem: Problem) -> list[object]:
    """Return all that a problem's results depend on, beside the equations, as plain values."""
    space = problem.space
    fixed = [
        [p.name, space.mechanism.value(p.name), p.min, p.max, str(p.status)]
        for p in space.mechanism.parameters.values()
        if not p.is_free
    ]
    free = [[p.name, p.min, p.max] for p in space.mechanism.free]
    targets = [[t.name, target_digest(t)] for t in problem.targets]
    return [fixed, free, sorted(space.polar), problem.priors, problem.shrinkage, problem.substeps, targets]


def target_digest(target: Target) -> str:
    """Return a digest of samples, their clock and weight, the step edges, offset, drift and what is its own."""
    total = hashlib.sha256()
    edges = target.excitation
    samples: list[Any] = [series for c in target.channels for series in (c.measured, c.rejected)]
    for series in (*samples, edges.initial, edges.times, edges.values.ravel()):
        for part in pieces_of(series):
            total.update(np.ascontiguousarray(series[part], dtype=np.float64).tobytes())
    base = target.base
    command = [target.command.start_angle_deg, target.command.start, target.command.begun_s]
    channels = list(map(_weight, target.channels))
    own = [[p.name, p.value, p.min, p.max, str(p.status)] for p in target.own]
    known = [base.sample_rate_hz, base.start_s, channels, command, own, target.clock_reference]
    total.update(digest(known).encode())
    return total.hexdigest()


def _weight(channel: TargetChannel) -> list[object]:
    colour = channel.prefilter
    own = [colour.coefficients, colour.sigma] if colour else None
    return [channel.quantity, channel.linear, channel.turns, channel.sigma, channel.rounding, own]
