"""How far a motion can be followed at all: where runs that begin all but equal have come apart.

A motion with sticking and slipping may multiply any difference, again and again. Then a model that is right to the
ninth digit is soon as wrong as any, and a fit of the whole record does not hold.
"""

from __future__ import annotations

import os

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.identification.computation.parallel import in_threads
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import Target, target_of
from mechid.identification.search.box import sample_box

DISPLACED = 1e-9
"""By so much of its value, or its range, each parameter is displaced: a thousandth of what the best record tells."""
POINTS = 8
"""Points of the box that are looked at, the file's own values first; a power of two. Of a record that is chaotic at
some only, two of the eight speak."""
WINDOW_S = 0.005
"""Over which runs are compared: that in which growth looks whether a record is followed."""
LONGEST_S = 20.0
"""Of a record that is looked at. It bounds the time of a check. A choice, not measured."""
SAFE = 0.5
"""Of the time in which runs come apart, what a stretch may have; a choice, not measured."""


def chaos_warnings(campaign: Campaign, *, points: int = POINTS) -> tuple[str, ...]:
    """Return a line for each record to be estimated from whose motion is chaotic, with what to write.

    Looked at are the file's own values and, up to so many `points`, some of the box in which the search starts: a
    record is told of where it is so at the file's values, or at a quarter of the points.
    """
    targets = tuple(target_of(r) for r in campaign.estimated if r.data is not None)
    if not campaign.mechanism.free or not targets:
        return ()
    problem = Problem(SearchSpace(campaign.mechanism), targets)
    own = problem.coordinates.of_records(problem.start)
    box = [np.concatenate([row, own]) for row in sample_box(problem.space, POINTS, 0)[:points]]
    looks = [(target, q) for target in targets for q in box]
    apart = in_threads(lambda look: apart_at_s(problem, *look), looks, os.cpu_count() or 1)
    lines = (_line(t.name, apart[k * len(box) : (k + 1) * len(box)]) for k, t in enumerate(targets))
    return tuple(filter(None, lines))


def _line(record: str, times: list[float | None]) -> str:
    """Say of a record when its runs come apart at each point, the file's own first."""
    finite = sorted(t for t in times if t is not None)
    if times[0] is None and 4 * len(finite) < len(times):
        return ""
    at = times[0] or finite[len(finite) // 2]
    where = "at the values of the mechanism file" if times[0] is not None else "where the search begins"
    count = f", and at {len(finite)} of {len(times)} points of the box" if len(times) > 1 else ""
    return f'record "{record}": {where} its motion is chaotic{count}: {chaos_words(at)}'


def chaos_words(apart_s: float) -> str:
    """Return what it means that runs come apart after some time, and what to write."""
    return (
        f"parameters displaced by {DISPLACED:g} of their values change it by more than the noise after "
        f"{apart_s:.3g} s, so that no fit of the whole record holds; write stretch_s = {_down(SAFE * apart_s):g} "
        "to have it followed in stretches, each from a start of its own"
    )


def apart_at_s(problem: Problem, target: Target, q: FloatArray) -> float | None:
    """Return the time in s after which runs at `q` and all but there have come apart by more than the noise.

    None where they do not, within the first 20 s.
    """
    rng = np.random.default_rng(0)
    size = np.maximum(np.abs(q), np.where(np.isfinite(problem.coordinates.span), 1e-3 * problem.coordinates.span, 1.0))
    displaced = problem.coordinates.clip(q + DISPLACED * size * rng.choice([-1.0, 1.0], q.size))
    rate = target.base.sample_rate_hz
    window, stop = max(round(WINDOW_S * rate), 1), min(target.samples, round(LONGEST_S * rate))
    runs = [problem.model.run(target, point, stop, block=_whole(window)).blocks() for point in (q, displaced)]
    outputs = [(problem.model.output(c.quantity), c.sigma) for c in target.channels]
    for here, there in zip(*runs, strict=True):
        for j, sigma in outputs:
            off = (here.y[:, j] - there.y[:, j]) / sigma
            whole = off[: off.size // window * window].reshape(-1, window)
            apart = np.flatnonzero(np.mean(whole**2, axis=1) > 1.0)
            if apart.size and here.start + apart[0] > 0:  # at once: the noise is none beside rounding
                return float((here.start + apart[0] * window) / rate)
    return None


def _whole(window: int) -> int:
    """Return how many samples are simulated in one go: whole windows of them."""
    return window * max(4096 // window, 1)


def _down(seconds: float) -> float:
    """Return a time rounded down to one digit."""
    digit = 10.0 ** np.floor(np.log10(seconds))
    return float(np.round(np.floor(seconds / digit + 1e-9) * digit, 9))
