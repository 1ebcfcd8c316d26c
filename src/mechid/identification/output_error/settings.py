"""Settings of the output-error problem: integration accuracy, noise levels and jumps of a signal."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ProblemSettings:
    """Thresholds of the problem that a search minimises, each with what fixed it."""

    promised_accuracy: float = 1e-5
    """Error promised of the integration, as a share of the record's RMS torque (docs/numerics.md)."""
    most_doublings: int = 3
    """Doublings of the steps a sample that are tried. One step keeps the promise on every record of the paper's
    mechanism (docs/numerics.md)."""
    jump_sigmas: float = 0.1
    """Noise levels by which an output has to jump for its samples to count less: a smaller jump takes under 1 % of
    them."""
    jump_widening: float = 5.0
    """Factor on the uncertainty of a sample at a jump: a recorder errs alike at every jump, which is no chance. With 1,
    a recorder without a filter moved parameters by 2.87 standard errors RMS, with 5 by 0.90 (docs/numerics.md)."""
    fewest_in_batch: int = 3
    """Points that are worth simulating side by side. A batch costs as much as 3 single runs
    (benchmarks/batch_of_runs.py: 0.37 to 0.4 of 8)."""
    least_noise_share: float = 1e-6
    """Noise level, as a share of a channel's standard deviation, below which arithmetic on the channel does not keep
    it."""
    least_amplitude_nm: float = 1e-12
    """Amplitude of a detent below which the derivative of its phase is rounding."""

    # The others are choices; no benchmark distinguishes values near them.

    on_bound: float = 1e-6
    """Share of its range within which a coordinate counts as on its bound."""
    results_kept: int = 256
    """Results that the memory of latest points holds."""
    mean_within: float = 1e-3
    """Prior of the mean of per-record values, as a share of the prior of one of them."""


PROBLEM = ProblemSettings()
