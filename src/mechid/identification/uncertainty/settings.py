"""Thresholds for noise levels, standard errors, and the visibility of parameters."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class NoiseRules:
    """Thresholds between noise, spikes and misfits, and the steps of the noise levels."""

    spike_deviations: float = 6.0
    """Robust standard deviations from which a sample of the residual is a spike; noise gets there once in 5e8."""
    lowering_errors: float = 4.0
    """Standard errors, of the level and of the residual's RMS, by which a residual has to be below the level for the
    level to be lowered. By chance once in 3e4."""
    most_raised_share: float = 0.3
    """Share of a channel's own standard deviation up to which its level is raised. All six measured campaigns are
    followed below it (docs/real_data.md)."""
    mostly_explained: float = 0.05
    """Residual over a channel's own standard deviation below which the model explains most of it. With it a current
    behind a low-pass gets no needless extra terms (tests/identification/uncertainty/test_noise_levels.py)."""

    # The others are choices; no benchmark distinguishes values near them.

    misfit: float = 1.2
    """Residual over the noise floor from which the model does not explain a record."""
    better_prefilter: float = 0.99
    """Ratio of noise below which a new prefilter replaces the old one."""
    most_rejected: float = 0.01
    """Share of a record's samples above which distant samples are a misfit, not spikes."""
    mostly_rounding: float = 0.5
    """Share of rounding in the noise variance from which the noise counts as rounding, whose colour is not
    stationary."""
    least_samples: int = 300
    """Samples from which the parameters fitted to a stretch do not lower its residual much."""
    raise_factor: float = 4.0
    """Factor by which a level is raised at a time."""


@dataclass(frozen=True)
class ErrorRules:
    """Thresholds at which standard errors are reported unchanged, widened, or withheld."""

    draws: int = 30
    """Draws of the quadratic check. They miss a threshold that a tenth of them would meet once in 24 times."""
    means_apart: float = 2.5
    """Standard deviations of the difference of two means of draws beyond which it is not chance; one in 80 is."""
    correlated_share: float = 0.5
    """Share of the variance beyond noise whose correlation is taken from the parts; the rest counts as independent.
    With few parts, unknown directions look known (70 benches, median squared distance of the truth over its expected
    value: 27 with all of it, 1.5 with half, 1.7 with none)."""
    most_switches: int = 20_000
    """Switches of a record that are examined, some 120 bytes each."""
    most_stretches: int = 1024
    """Largest number of parts over time, so that memory does not grow with the record."""

    # The others are choices; no benchmark distinguishes values near them.

    contradiction: float = 3.0
    """Standard errors beyond its bound from which the records contradict it."""
    cost_departure: float = 1.0
    """Sigmas squared by which the cost of a draw may differ from the quadratic."""
    reliance: float = 1.1
    """Growth of a standard error without some records from which it depends on them."""
    share_of_gap: float = 0.1
    """Standard deviation of an instant over its gap to the next switch, above which their order is not certain."""
    jackknife_ridge: float = 1.02
    """Factor on the information of all parts before one is left out. It bounds the step in a direction that one part
    alone determines."""
    ratio: float = 1.15
    """Scatter ratio from which parts contradict each other where the noise has no white model for a z score."""
    phases_a_record: int = 8
    """Degrees of freedom of a record's phases; fewer than the phases, since neighbouring phases are not independent."""
    phases: int = 32
    """Parts of a full step of the command."""
    stretch_s: float = 0.1
    """Approximate length of a part over time."""
    quarters: int = 4
    """Parts of a record where it is split evenly."""
    severe_disagreement: float = 3.0
    """Scatter ratio of the parts above which a warning states the limits of the errors."""
    unseen_share: float = 1e-4
    """Share of a parameter in an invisible direction below which that share is rounding."""


@dataclass(frozen=True)
class VerdictRules:
    """Thresholds of the identifiability verdicts."""

    points: int = 8
    """Points of the box that are examined, the file's own values first; a power of two. Of a record that is chaotic at
    some points only, two of the eight show it."""
    displacement: float = 1e-9
    """Share of its value, or its range, by which each parameter is displaced: a thousandth of the precision that the
    best record allows."""
    rounding_change: float = 1e-6
    """Change of a sample over the whole range of a coordinate, in sigmas of its noise, that is rounding."""

    # The others are choices; no benchmark distinguishes values near them.

    partner_correlation: float = 0.9
    """Magnitude of the correlation from which another parameter takes part in a ruined estimate."""
    involved_share: float = 0.2
    """Share of the largest component of a direction from which a parameter is named."""
    equal_difference: float = 0.2
    """Relative difference below which two components count as equal."""
    most_relative: float = 100.0
    """Magnitude of standard error over value from which a parameter without two bounds is not known."""
    parts: int = 10
    """Equal parts of a record after the instant at which runs diverge."""
    parts_apart: int = 8
    """Parts that must contain a window with diverged runs for the divergence to count as lasting."""
    fewest_windows: int = 40
    """Windows after that instant, 0.2 s, that the decision needs."""
    longest_s: float = 20.0
    """Length of a record that is examined; it bounds the time of a check."""
    safe_share: float = 0.5
    """Longest stretch over the time in which runs diverge."""
    least_excess: float = 1e-7
    """Excess in SI units below which a parameter equals its lower limit, as static friction over Coulomb friction."""
    negligible_change: float = 1e-3
    """Change of all samples together over the whole range of a coordinate, in sigmas, that counts as zero."""
    look_s: float = 1.0
    """Time of each record that is simulated to see which parameters change it, from its first motion on."""


NOISE = NoiseRules()
ERRORS = ErrorRules()
VERDICTS = VerdictRules()
