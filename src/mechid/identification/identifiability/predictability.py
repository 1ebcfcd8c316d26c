"""Predictability of a motion: the time after which runs that begin all but equal have come apart.

A motion with sticking and slipping may multiply any difference, again and again. Then a model that is right to the
ninth digit is soon as wrong as any, and a fit of the whole record does not hold.
"""

from __future__ import annotations

import os

import numpy as np

from mechid.arrays import BoolArray, FloatArray
from mechid.campaign import Campaign
from mechid.identification.computation.parallel import in_threads
from mechid.identification.identifiability.settings import VERDICTS
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import Target, target_of
from mechid.identification.search.box import sample_box
from mechid.identification.search.settings import SEARCH


def chaos_warnings(campaign: Campaign, *, points: int = VERDICTS.points) -> tuple[str, ...]:
    """Return a line for each record to be estimated from whose motion is chaotic, with what to write.

    Looked at are the file's own values and, up to so many `points`, some of the box in which the search starts: a
    record is told of where it is so at the file's values, or at a quarter of the points.
    """
    targets = tuple(target_of(r) for r in campaign.estimated if r.data is not None)
    if not campaign.mechanism.free or not targets:
        return ()
    problem = Problem(SearchSpace(campaign.mechanism), targets)
    own = problem.coordinates.of_records(problem.start)
    box = [np.concatenate([row, own]) for row in sample_box(problem.space, VERDICTS.points, 0)[:points]]
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
        f"parameters displaced by {VERDICTS.displaced:g} of their values change it by more than the noise from "
        f"{apart_s:.3g} s on, so that no fit of the whole record holds; "
        f"write stretch_s = {_down(VERDICTS.safe_share * apart_s):g} "
        "to have it followed in stretches, each from a start of its own"
    )


def apart_at_s(problem: Problem, target: Target, q: FloatArray) -> float | None:
    """Return the time in s after which runs at `q` and all but there have come apart by more than the noise, for good.

    None where they do not within the first 20 s, or meet again: a single stick-slip event that falls the other way
    is no chaos. First all parameters are displaced together. Where that run stays apart, at least one run with a
    single parameter displaced has to stay apart as well.
    """
    size = np.maximum(np.abs(q), np.where(np.isfinite(problem.coordinates.span), 1e-3 * problem.coordinates.span, 1.0))
    signs = np.random.default_rng(0).choice([-1.0, 1.0], q.size)
    together_s = _apart_for_good_s(problem, target, q, VERDICTS.displaced * size * signs)
    if together_s is None:
        return None
    alone = (VERDICTS.displaced * size * signs * one for one in np.eye(q.size))
    apart = any(_apart_for_good_s(problem, target, q, step) is not None for step in alone)
    return together_s if apart else None


def _apart_for_good_s(problem: Problem, target: Target, q: FloatArray, step: FloatArray) -> float | None:
    """Return when the runs at `q` and a step from it come apart and stay so, s; None where they do not."""
    rate = target.base.sample_rate_hz
    window, stop = max(round(SEARCH.gate_window_s * rate), 1), min(target.samples, round(VERDICTS.longest_s * rate))
    points = q, problem.coordinates.clip(q + step)
    runs = [problem.model.run(target, point, stop, block=_whole(window)).blocks() for point in points]
    outputs = [(problem.model.output(c.quantity), c.sigma) for c in target.channels]
    distances: list[FloatArray] = []
    for here, there in zip(*runs, strict=True):
        off = np.array([(here.y[:, j] - there.y[:, j]) / sigma for j, sigma in outputs])
        whole = off[:, : off.shape[1] // window * window].reshape(len(outputs), -1, window)
        distances.append(np.max(np.mean(whole**2, axis=2), axis=0))
    first = first_apart_for_good(np.concatenate(distances) > 1.0)
    return None if first is None else float(first * window / rate)


def first_apart_for_good(apart: BoolArray) -> int | None:
    """Return the first window from which two runs are apart and do not meet again; None where there is none.

    Parameters
    ----------
    apart : (W,) of bool
        Windows in which the runs differ by more than the noise. Between two steps a motion may die out, so that
        not every window of runs that are apart has to be so.

    Examples
    --------
    >>> met_again = np.arange(1000) == 400
    >>> first_apart_for_good(met_again) is None
    True
    >>> first_apart_for_good(np.arange(1000) >= 400)
    400
    """
    found = np.flatnonzero(apart)
    if not found.size or found[0] == 0 or apart.size - found[0] < VERDICTS.fewest_windows:  # 0: noise is rounding alone
        return None
    parts = np.array_split(apart[found[0] :], VERDICTS.parts)
    return int(found[0]) if sum(map(np.any, parts)) >= VERDICTS.parts_apart else None


def _whole(window: int) -> int:
    """Return how many samples are simulated in one go: whole windows of them."""
    return window * max(4096 // window, 1)


def _down(seconds: float) -> float:
    """Return a time rounded down to one digit."""
    digit = 10.0 ** np.floor(np.log10(seconds))
    return float(np.round(np.floor(seconds / digit + 1e-9) * digit, 9))
