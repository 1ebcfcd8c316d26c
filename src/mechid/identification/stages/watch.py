"""Watch over a search: its messages, its journal, and the fit that it keeps on its way."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from mechid.identification.computation.journal import Journal
from mechid.identification.computation.progress import Listener, Progress, silent
from mechid.identification.result.fit import StageReport
from mechid.identification.result.search_state import SearchState
from mechid.identification.stages.over_noise import OverNoise


class Watch:
    """The listener, journal and clock of a search, and its latest state, which an interruption leaves usable.

    `keep` is called with states worth a result of their own, before work that whoever ends the search may cut off.
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
        self.listener, self.total, self.journal = listener, total, journal or Journal()
        self.began = time.perf_counter()
        self.noise = OverNoise(state.problem)

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
