"""How far off each record is where the search stands: its residual's RMS over its noise floor, over all of it.

The cost of the search does not tell: it counts what is followed so far, and in the end noise as it was released.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from contextvars import Context
from dataclasses import replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.stages.settings import STAGES


class OverNoise:
    """Looks at all records now and then: at the first report of a stage, else as often as its share of time allows.

    Parameters
    ----------
    problem : Problem
        At the search's beginning: its noise levels are the floors.
    """

    def __init__(self, problem: Problem) -> None:
        self.floors = {(t.name, c.quantity): c.sigma for t in problem.targets for c in t.channels}
        self.stage, self.due = "", -math.inf

    def seen(self, stage: str, problem: Problem, q: FloatArray) -> dict[str, float]:
        """Return residual over noise floor by record at `q`, infinite where a simulation fails; mostly nothing."""
        began = time.perf_counter()
        if stage == self.stage and began < self.due:
            return {}
        # within it nobody is asked whether to go on: the clock makes looks, what ends a search counts without them
        found = Context().run(over_noise, problem, q, self.floors)
        ended = time.perf_counter()
        self.stage, self.due = stage, ended + (ended - began) / STAGES.share_of_time
        return found


def over_noise(problem: Problem, q: FloatArray, floors: Mapping[tuple[str, str], float]) -> dict[str, float]:
    """Return residual RMS over noise floor of each record, whole, offset and drift projected out.

    Parameters
    ----------
    problem : Problem
    q : (n,)
    floors : mapping
        Noise floor by record and quantity, in the channel's unit.
    """
    plain = replace(problem, targets=tuple(_by_floor(t, floors) for t in problem.targets))
    with np.errstate(all="ignore"):
        norms = plain.norms(q, plain.whole())
    return {t.name: norm / math.sqrt(_counted(t)) for t, norm in zip(plain.targets, norms, strict=True)}


def _by_floor(target: Target, floors: Mapping[tuple[str, str], float]) -> Target:
    """Return a target with its floor as the noise of each channel, not whitened."""
    return target.each(lambda c: replace(c, sigma=floors.get((target.name, c.quantity), c.sigma), prefilter=None))


def _counted(target: Target) -> int:
    """Return the samples of all channels that count."""
    return max(sum(target.samples - c.rejected.size for c in target.channels), 1)
