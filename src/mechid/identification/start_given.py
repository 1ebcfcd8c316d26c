"""Identify from values that the user gives: they take the place of the search for a start."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.campaign import Campaign
from mechid.identification.computation.progress import Listener, Progress, silent
from mechid.identification.identify import identify, make_problem
from mechid.identification.result.fit import Fit
from mechid.identification.result.search_state import SearchState
from mechid.identification.search.gates import grow_horizons
from mechid.identification.search.run_up import run_up
from mechid.identification.stages.watch import Watch


def identify_from(
    campaign: Campaign,
    values: Mapping[str, float],
    *,
    seed: int = 0,
    workers: int | None = None,
    listener: Listener = silent,
) -> Fit:
    """Identify from a start: horizons grow from it to the records' ends, then all that is free is fitted jointly.

    Parameters
    ----------
    campaign : Campaign
        Its stages are left out.
    values : mapping of str to float
        By dotted name; what is not among them starts at the file's value.
    seed, workers, listener
        As of `identify`.

    Returns
    -------
    Fit
        Also where the fit did not succeed: its `outcome` says so.

    Raises
    ------
    FitError
        If nothing is free, or no record is to be estimated from.
    """
    planned = replace(campaign, stages=())
    problem = make_problem(planned, workers or os.cpu_count() or 1)
    point = run_up(problem, problem.coordinates.point(values), known=values)
    state = SearchState(problem, point, problem.whole())
    watch = Watch(state, listener, 3)
    total = sum(t.samples for t in problem.targets)

    def tell(line: str) -> None:
        watch.tell("gated growth", line, problem.total_norm(watch.latest.q, state.windows) ** 2)

    def on_growth(q: FloatArray, gates: Mapping[str, int]) -> None:
        watch.note(state.at(q))
        tell(f"{100.0 * sum(gates.values()) / total:.1f} % of all samples followed")

    tell("begins")
    grown = state.at(grow_horizons(problem, state.q, np.random.default_rng(seed), on_growth).q)
    spent = watch.seconds

    def told_of_the_rest(progress: Progress) -> None:
        number = min(progress.number + 1, 3)
        listener(replace(progress, number=number, total=3, elapsed_s=spent + progress.elapsed_s))

    return identify(planned, seed=seed, workers=workers, listener=told_of_the_rest, near=grown.values)
