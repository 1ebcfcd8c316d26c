"""Watch over a search: its messages, its journal, its latest state, and the residual-to-noise ratio of records.

The cost of the search does not show how well a record is followed: it covers only the followed samples, and at the end
it uses the released noise.
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
    """Occasional measurement of all records: at the first report of a stage, then as often as its share of time allows.

    Parameters
    ----------
    problem : Problem
        Problem at the search's beginning: its noise levels are the floors.
    """

    def __init__(self, problem: Problem) -> None:
        self.floors = {(t.name, c.quantity): c.sigma for t in problem.targets for c in t.channels}
        self.stage, self.due = "", -math.inf

    def measure(self, stage: str, problem: Problem, q: FloatArray) -> dict[str, float]:
        """Return the residual-to-noise ratio by record at `q`, or, to save time, mostly nothing.

        The ratio is infinite for a record whose simulation fails.
        """
        began = time.perf_counter()
        if stage == self.stage and began < self.due:
            return {}
        # An empty context disables interrupts and work counting: measurements depend on the clock, budgets must not.
        found = Context().run(residual_to_noise, problem, q, self.floors)
        ended = time.perf_counter()
        self.stage, self.due = stage, ended + (ended - began) / STAGES.share_of_time
        return found


def residual_to_noise(problem: Problem, q: FloatArray, floors: Mapping[tuple[str, str], float]) -> dict[str, float]:
    """Return the ratio of residual RMS to noise floor of each whole record, with offset and drift projected out.

    Parameters
    ----------
    problem : Problem
    q : (n,)
    floors : mapping
        Noise floor by record and quantity, in the channel's unit.
    """
    plain = replace(problem, targets=tuple(_use_floors(t, floors) for t in problem.targets))
    with np.errstate(all="ignore"):
        norms = plain.norms(q, plain.whole_windows())
    return {t.name: norm / math.sqrt(_counted_samples(t)) for t, norm in zip(plain.targets, norms, strict=True)}


def _use_floors(target: Target, floors: Mapping[tuple[str, str], float]) -> Target:
    """Return a target with its floor as the noise of each channel, not whitened."""
    return target.map_channels(
        lambda c: replace(c, sigma=floors.get((target.name, c.quantity), c.sigma), prefilter=None)
    )


def _counted_samples(target: Target) -> int:
    """Return the number of samples of all channels that are not rejected."""
    # A record may be rejected as a whole.
    return max(sum(target.samples - c.rejected.size for c in target.channels), 1)


class Watch:
    """Listener, journal and clock of a search, and its latest state, which stays usable after an interruption.

    `keep` is called with states that are results in themselves, before work that may be interrupted. `compile_ahead` is
    called with families of effects that will be needed, and tells whether it has started a compilation. `note` is the
    only method by which a search changes the state here; `noise` times its own measurements. A step notes its state and
    returns it.

    Parameters
    ----------
    state : SearchState
        Start of the search.
    listener : callable
        Called with each progress report.
    total : int
        Number of stages that are reported.
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
        """Elapsed seconds, counting results from the journal as if they were computed now."""
        return float(time.perf_counter() + self.journal.saved_s) - self.began

    def tell(self, stage: str, line: str, cost: float | None = None) -> None:
        """Report progress of the running stage, at the latest state."""
        at = self.latest
        number = min(len(at.stages) + 1, self.total)
        # A measurement costs a simulation of all records, which nobody would see.
        noise = {} if self.listener is silent else self.noise.measure(stage, at.problem, at.q)
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
