"""Watch over a search: its messages, its journal, the fit that it keeps, and the residual-to-noise ratio of records.

The cost of the search does not show how far off a record is: it counts what is followed so far, and in the end noise
as it was released.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from contextvars import Context
from dataclasses import replace

import numpy as np

from mechid.arrays import FloatArray
from mechid.identification.computation.journal import Journal
from mechid.identification.computation.progress import Listener, Progress, silent
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.target import Target
from mechid.identification.result.fit import StageReport
from mechid.identification.result.search_state import SearchState
from mechid.identification.stages.families import Families
from mechid.identification.stages.settings import STAGES


class ResidualToNoise:
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
        found = Context().run(residual_to_noise, problem, q, self.floors)
        ended = time.perf_counter()
        self.stage, self.due = stage, ended + (ended - began) / STAGES.share_of_time
        return found


def residual_to_noise(problem: Problem, q: FloatArray, floors: Mapping[tuple[str, str], float]) -> dict[str, float]:
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
        norms = plain.norms(q, plain.whole_windows())
    return {t.name: norm / math.sqrt(_counted(t)) for t, norm in zip(plain.targets, norms, strict=True)}


def _by_floor(target: Target, floors: Mapping[tuple[str, str], float]) -> Target:
    """Return a target with its floor as the noise of each channel, not whitened."""
    return target.map_channels(
        lambda c: replace(c, sigma=floors.get((target.name, c.quantity), c.sigma), prefilter=None)
    )


def _counted(target: Target) -> int:
    """Return the samples of all channels that count."""
    return max(sum(target.samples - c.rejected.size for c in target.channels), 1)


class Watch:
    """The listener, journal and clock of a search, and its latest state, which an interruption leaves usable.

    `keep` is called with states worth a result of their own, before work that whoever ends the search may cut off;
    `compile_ahead` with the families of effects that are about to be needed, and tells whether it has begun anything.
    `note` is the one place where a search changes anything here; `noise` keeps its own time for looks at all records. A
    step notes what it has come to, and returns it.

    Parameters
    ----------
    state : SearchState
        Where the search begins.
    listener : callable
        Called with each report of progress.
    total : int
        How many stages are told of.
    journal : Journal or None
    """

    def __init__(self, state: SearchState, listener: Listener, total: int, journal: Journal | None = None) -> None:
        self.latest = state
        self.keep: Callable[[SearchState], None] = lambda state: None
        self.compile_ahead: Callable[[Families], bool] = lambda families: False
        self.listener, self.total, self.journal = listener, total, journal or Journal()
        self.began = time.perf_counter()
        self.noise = ResidualToNoise(state.problem)

    def note(self, state: SearchState) -> SearchState:
        """Keep a state as the latest, and return it."""
        self.latest = state
        return state

    @property
    def seconds(self) -> float:
        """Seconds so far, that run on through a resumed search as if what the journal holds were worked out now."""
        return float(time.perf_counter() + self.journal.saved_s) - self.began

    def tell(self, stage: str, line: str, cost: float | None = None) -> None:
        """Report progress of the stage at work, at the latest state."""
        at = self.latest
        number = min(len(at.stages) + 1, self.total)
        noise = {} if self.listener is silent else self.noise.seen(stage, at.problem, at.q)
        self.listener(Progress(number, self.total, stage, line, cost, self.seconds, at.values, noise))

    def close(
        self, state: SearchState, name: str, free: tuple[str, ...], cost: float, evaluations: int, note: str = ""
    ) -> SearchState:
        """Note a finished stage, and return the state with it."""
        rates = {t.name: t.base.sample_rate_hz for t in state.problem.targets}
        used = {record: (w[1] - w[0] - 1) / rates[record] for record, w in state.windows.items()}
        before = sum(stage.seconds for stage in state.stages)
        report = StageReport(
            name=name,
            records=used,
            free=free,
            cost=cost,
            evaluations=evaluations,
            seconds=self.seconds - before,
            note=note,
        )
        return self.note(replace(state, stages=(*state.stages, report)))
