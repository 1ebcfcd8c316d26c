"""Refits of a finished fit: its optimum, their progress and their journal."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path

from mechid.identification.computation.journal import Journal, digest
from mechid.identification.computation.parallel import one_core_algebra
from mechid.identification.computation.progress import Listener, Progress
from mechid.identification.computation.workforce import working_on
from mechid.identification.output_error.digests import campaign_digests
from mechid.identification.result.fit import Fit, Optimum
from mechid.progress.listening import progress_listener

TellShare = Callable[[str, float | None], None]


@contextmanager
def at_optimum(
    fit: Fit, stage: str, workers: int, executor: Executor | None, listener: Listener | None
) -> Iterator[tuple[Optimum, TellShare]]:
    """Return the optimum of a fit, and the function that reports the progress of its refits.

    Parameters
    ----------
    fit : Fit
    stage : str
        Name of the work in the reports.
    workers : int
        Threads.
    executor, listener
        As of `mechid.profile`.
    """
    began = time.perf_counter()
    with one_core_algebra(), working_on(executor), progress_listener(listener) as tell:
        yield (
            fit.optimum_on(workers),
            lambda words, cost: tell(Progress(1, 1, stage, words, cost, time.perf_counter() - began)),
        )


def refit_journal(fit: Fit, path: Path | str | None, *, resume: bool) -> Journal | None:
    """Return the journal of a fit's refits, None without a file; warn of what is odd about it."""
    if path is None:
        return None
    values = [[name, p.value, str(p.status)] for name, p in fit.parameters.items()]
    inputs = {**campaign_digests(fit.required_campaign), "estimate.json": digest(values)}
    opened = Journal.open(Path(path), inputs, resume=resume)
    if opened.notice:
        warnings.warn(opened.notice, stacklevel=2)
    return opened
