"""Settings of the distribution of work over processes."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class WorkSettings:
    """Sizes and times of batches of work. Results do not depend on them."""

    batch_s: float = 1.0
    """Least time that a batch is to take: hundreds of times what sending it costs."""
    served_s: float = 0.01
    """Time between two batches: twice what sending one and taking it back costs here and in Dask's scheduler, so that
    neither is what many workers wait for."""
    ahead: int = 2
    """Batches under way for each worker: one at work, one that waits."""

    # The others are choices; no benchmark distinguishes values near them.

    recent: int = 64
    """Tasks whose median time counts."""
    asked_s: float = 0.2
    """Time between two questions whether to go on."""
    problems_kept: int = 4
    """Problems that a worker keeps."""
    scheduler_patience_s: float = 10.0
    """Time within which a scheduler has to answer."""


WORK = WorkSettings()
