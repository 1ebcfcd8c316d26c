"""Settings of the distribution of work over processes."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class WorkSettings:
    """Sizes and times of batches of work. Results do not depend on them."""

    batch_s: float = 1.0
    """Least duration of a batch: hundreds of times the cost of sending it."""
    served_s: float = 0.01
    """Time between two batches: twice the cost of sending one and receiving it, here and in Dask's scheduler, so that
    many workers do not wait for either."""
    ahead: int = 2
    """Batches in flight for each worker: one running, one waiting."""

    # The others are choices; no benchmark distinguishes values near them.

    recent: int = 64
    """Tasks whose median time counts."""
    asked_s: float = 0.2
    """Time between two checks for an interrupt."""
    problems_kept: int = 4
    """Problems that a worker keeps."""
    scheduler_patience_s: float = 10.0
    """Time within which a scheduler must answer."""


WORK = WorkSettings()
