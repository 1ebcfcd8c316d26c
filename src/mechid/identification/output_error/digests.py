"""Digests of problems, campaigns and files: equal digests mean equal inputs."""

from __future__ import annotations

import hashlib
from dataclasses import astuple
from pathlib import Path
from typing import Any

import numpy as np

from mechid.campaign import Campaign
from mechid.identification.computation.journal import digest
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target, TargetChannel, target_of
from mechid.plant.mechanism import Mechanism
from mechid.reading.whole import is_file
from mechid.records.formats import digest_of
from mechid.signal.stored_series import pieces_of


def identity(problem: Problem) -> list[object]:
    """Return everything that a problem's results depend on, except the equations, as plain values."""
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
    """Return a digest of a target: samples, clock, weights, step edges, offset, drift and record parameters."""
    total = hashlib.sha256()
    edges = target.excitation
    samples: list[Any] = [series for c in target.channels for series in (c.measured, c.rejected)]
    for series in (*samples, edges.initial, edges.times, edges.values.ravel()):
        for part in pieces_of(series):
            # Stored series are read in pieces, because they may be larger than memory.
            total.update(np.ascontiguousarray(series[part], dtype=np.float64).tobytes())
    base = target.base
    command = [target.command.start_angle_deg, target.command.start, target.command.begun_s]
    channels = list(map(_weighting, target.channels))
    own = [[p.name, p.value, p.min, p.max, str(p.status)] for p in target.own]
    known = [base.sample_rate_hz, base.start_s, channels, command, own, target.clock_reference]
    total.update(digest(known).encode())
    return total.hexdigest()


def _weighting(channel: TargetChannel) -> list[object]:
    colour = channel.prefilter
    own = [colour.coefficients, colour.sigma] if colour else None
    return [channel.quantity, channel.linear, channel.turns, channel.sigma, channel.rounding, own]


def campaign_digests(campaign: Campaign) -> dict[str, str]:
    """Return digests of the mechanism, of each record used for estimation, of stages and options."""
    return {
        "mechanism": _mechanism_digest(campaign.mechanism),
        "stages": digest([list(astuple(stage)) for stage in campaign.stages]),
        "options": digest(list(astuple(campaign.options))),
        **{f"record {r.name}": target_digest(target_of(r)) for r in campaign.estimated if r.data is not None},
    }


def file_digests(campaign: Campaign) -> dict[str, str]:
    """Return SHA-256 by file name: of the campaign's and the commands' files as they are, of records as read."""
    commands = [path for record in campaign.records for path in record.command_files]
    own = {path.name: file_digest(path) for path in (*commands, campaign.path, campaign.mechanism_path)}
    return own | {r.data.path.name: r.data.digest for r in campaign.records if r.data is not None}


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file's bytes; empty if the file does not exist."""
    return digest_of(path) if is_file(path) else ""


def _mechanism_digest(mechanism: Mechanism) -> str:
    entries = [
        [p.name, p.value, p.min, p.max, p.sigma, str(p.status), p.tied_to] for p in mechanism.parameters.values()
    ]
    return digest([mechanism.plant.digest, entries])
