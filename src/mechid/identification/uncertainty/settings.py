"""Rules for noise levels, for standard errors, and for what records can tell of a parameter."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class NoiseRules:
    """When a residual is noise, a spike or a misfit, and by how much noise levels are changed."""

    far_off: float = 6.0
    """Robust standard deviations from which a sample of the residual is a spike; noise gets there once in 5e8."""
    sure: float = 4.0
    """Standard errors, of the level and of the residual's RMS, by which a residual has to be below the level for the
    level to be lowered. By chance once in 3e4."""
    most_raised_share: float = 0.3
    """Share of the standard deviation of what moves in a channel, up to which its level is raised. All six measured
    campaigns are followed below it (docs/real_data.md)."""
    mostly_explained: float = 0.05
    """Share of what moves in a channel that is left where a model explains most of it. With it a current behind a
    low-pass gets no needless extra terms (tests/identification/uncertainty/test_noise_levels.py)."""

    # The others are choices; no benchmark distinguishes values near them.

    misfit: float = 1.2
    """Residual over the noise floor from which a record is not explained."""
    quieter: float = 0.99
    """Share of a prefilter's noise below which another prefilter is much better."""
    most_rejected: float = 0.01
    """Share of a record beyond which distant samples are no spikes."""
    mostly_rounding: float = 0.5
    """Share of a noise's variance from which it counts as rounding, whose colour is not stationary."""
    least_samples: int = 300
    """Samples from which a stretch counts for more than the parameters that are fitted to it."""
    raise_factor: float = 4.0
    """Factor by which a level is raised at a time."""


@dataclass(frozen=True)
class ErrorRules:
    """When standard errors are reported as they are, widened, or withheld."""

    draws: int = 30
    """Draws of the quadratic check. They miss a threshold that a tenth of them would meet once in 24 times."""
    means_apart: float = 2.5
    """Standard deviations of the difference of two means of draws beyond which it is not chance; one in 80 is."""
    correlated_share: float = 0.5
    """Share of the variance beyond noise that counts as correlated as the parts have it, the rest as independent: so
    few parts make directions look known that are not (70 benches: squared distance of the truth 27 times what it should
    be with all of it, 1.5 with half, 1.7 with none, in the median)."""
    most_switches: int = 20_000
    """Switches of a record that are looked at, some 120 bytes each."""
    most_stretches: int = 1024
    """Parts over time of a long record: their number does not grow with it."""

    # The others are choices; no benchmark distinguishes values near them.

    contradicted: float = 3.0
    """Standard errors beyond its bound from which a parameter contradicts it."""
    cost_departure: float = 1.0
    """Sigmas squared by which the cost of a draw may differ from the quadratic."""
    told_by: float = 1.1
    """Factor by which a standard error grows without a record that tells of its parameter."""
    share_of_gap: float = 0.1
    """Standard deviation of an instant over its gap to the next switch, beyond which their order is not certain."""
    irreplaceable: float = 1.02
    """Information of all parts over that of all but one, from which that part alone knows a direction."""
    ratio: float = 1.15
    """Ratio from which parts contradict each other where noise has no white model to count chance by."""
    phases_a_record: int = 8
    """Degrees of freedom that a record's phases count as: neighbouring phases are not independent."""
    phases: int = 32
    """Parts of a full step of the command."""
    stretch_s: float = 0.1
    """About how long a part over time is."""
    quarters: int = 4
    """Parts of a record where it is split evenly."""
    far_beyond: float = 3.0
    """Disagreement of the parts, over what noise explains, from which the limits of the errors are stated."""
    unseen_share: float = 1e-4
    """Share of a parameter in a direction that no record sees, below which it is rounding."""


@dataclass(frozen=True)
class VerdictRules:
    """Thresholds of the identifiability verdicts."""

    points: int = 8
    """Points of the box that are looked at, the file's own values first; a power of two. Of a record that is chaotic at
    some points only, two of the eight show it."""
    displaced: float = 1e-9
    """Share of its value, or its range, by which each parameter is displaced: a thousandth of what the best record
    tells."""
    rounding_change: float = 1e-6
    """Change of a sample over the whole range of a coordinate, in sigmas of its noise, that is rounding."""

    # The others are choices; no benchmark distinguishes values near them.

    partner: float = 0.9
    """Magnitude of the correlation from which another parameter has part in a ruined estimate."""
    involved: float = 0.2
    """Share of the largest component of a direction from which a parameter is named."""
    equal: float = 0.2
    """Relative difference of two components that count as the same."""
    most_relative: float = 100.0
    """Magnitude of standard error over value from which a parameter without two bounds is not known."""
    parts: int = 10
    """Equal parts of a record behind the instant at which runs come apart."""
    parts_apart: int = 8
    """Parts that have to hold a window apart for the runs to stay so."""
    fewest_windows: int = 40
    """Windows behind that instant, 0.2 s, from which this can be decided."""
    longest_s: float = 20.0
    """Length of a record that is looked at. It bounds the time of a check."""
    safe_share: float = 0.5
    """Share of the time in which runs come apart that a stretch may have."""
    least_excess: float = 1e-7
    """In SI units: a parameter this little above the one it never lies below is at its least, as static friction."""
    negligible_change: float = 1e-3
    """Change of all samples together over the whole range of a coordinate, in sigmas, that counts as zero."""
    look_s: float = 1.0
    """Part of each record that is looked at, from its first motion on."""


NOISE = NoiseRules()
ERRORS = ErrorRules()
VERDICTS = VerdictRules()
