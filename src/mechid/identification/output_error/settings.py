"""Settings of the output-error problem: integration accuracy, noise levels and jumps of a signal."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ProblemSettings:
    """Thresholds of the problem that a search minimises, each with its origin."""

    promised_accuracy: float = 1e-5
    """Promised integration error, as a share of the record's RMS torque (docs/numerics.md)."""
    most_doublings: int = 3
    """Doublings of the steps per sample that are tried. One step keeps the promise on every record of the paper's
    mechanism (docs/numerics.md)."""
    jump_sigmas: float = 0.1
    """Smallest jump of an output, in noise levels, whose samples have a reduced weight: a smaller jump would reduce it
    by less than 1 %."""
    jump_widening: float = 5.0
    """Factor on the uncertainty of a sample at a jump: a recorder makes the same error at every jump, so the errors are
    not independent. With 1, a recorder without a filter moved parameters by 2.87 standard errors RMS, with 5 by 0.90
    (docs/numerics.md)."""
    fewest_in_batch: int = 3
    """Fewest points that are simulated as a batch. A batch costs as much as 3 single runs (benchmarks/batch_of_runs.py:
    0.37 to 0.4 of 8)."""
    shortest_in_batch: int = 8192
    """Fewest samples that are simulated as a batch. Short windows, as in a multi-start, gain nothing by it
    (docs/scaling.md), and the first batch of a layout waits 3 s for its kernel."""
    fewest_to_divide: int = 8192
    """Fewest samples of a record for each thread that shares its directions; a search's short windows stay whole."""
    least_noise_share: float = 1e-6
    """Smallest noise level, as a share of a channel's standard deviation, that survives arithmetic on the channel."""
    least_amplitude_nm: float = 1e-12
    """Amplitude of a detent below which the derivative of its phase is rounding error."""

    # The others are choices; no benchmark distinguishes values near them.

    on_bound: float = 1e-6
    """Share of its range within which a coordinate counts as on its bound."""
    results_kept: int = 256
    """Results that the point cache holds."""
    mean_within: float = 1e-3
    """Prior of the mean of per-record values, as a share of the prior of one of them."""


PROBLEM = ProblemSettings()
