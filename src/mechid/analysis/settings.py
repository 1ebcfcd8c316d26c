"""Thresholds of the analysis of records and residuals: resonances, orders, lines and noise."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ResonanceRules:
    """When a peak over the rate, or a hump of a density, is a resonance."""

    alike: float = 0.06
    """Relative distance within which peaks are one resonance."""
    stands_out: float = 2.0
    """Height of a peak of an order over the rate, as a multiple of its surroundings on both sides."""
    above_noise: float = 6.0
    """Standard errors by which such a peak exceeds zero."""
    hump_db: float = 3.0
    """Height of a hump of the density over both sides, and over the upper half of the band."""
    smooth: float = 0.03
    """Relative width over which a density is smoothed."""
    points_a_decade: int = 400
    """Frequencies of the smoothed density."""
    line_bins: float = 2.5
    """Bins on both sides that belong to a line under a Hann window."""
    lines_a_hump: float = 4.0
    """Least frequency of a hump of lines, in distances of the lines."""
    wider: float = 0.75
    """Least half-width of such a hump, in distances of the lines: it is wider than one line."""
    rates_apart: float = 0.1
    """Relative distance of step rates that are different ones."""


@dataclass(frozen=True)
class OrderRules:
    """Orders of the step rate in records and residuals."""

    window_steps: float = 16.0
    """Least full steps of a window where the record has them: orders that differ by a sixteenth are separate then."""
    least_steps: float = 4.0
    """Full steps below which a record has no orders."""
    highest_share: float = 0.8
    """Share of half the sample rate above which an order is left out."""
    resolved: float = 3.0
    """Standard errors from which a line is above the noise, and its amplitude and phase are compared."""
    one_rate: float = 0.02
    """Difference of rates, as a share of the largest, below which they are one rate."""
    rate_step: float = 0.05
    """Relative difference of the rates of windows below which they are one rate."""
    bins: int = 64
    """Bins of a spectrum around a line, which show how large noise makes it."""
    fewest_bins: int = 3
    """Bins of a band from which it has a density."""
    turns: float = 2.0
    """Turns of the difference of two neighbouring orders that a window has to hold for both to be separate."""
    steady: float = 1e-3
    """Relative difference of a record's rates up to which they are one: its orders then stand still beside the hum."""
    hum_apart: float = 2.0
    """Inverse durations from which an order is separate from a multiple of the mains."""
    hum_room: float = 7.0
    """Inverse durations from which it is clear of lines that follow a drift."""
    quarters: int = 4
    """Parts of the step rate whose multiples are lines of the motor."""
    near_bins: float = 0.5
    """Distance in bins within which a line is at a multiple of the step rate."""
    near: float = 5e-4
    """The same, relative to the frequency."""
    by_chance: float = 0.2
    """Chance of any line to be that near to a multiple, up to which it is evidence."""
    false_alarm: float = 0.01
    """Chance that noise alone makes a line of any component at any order of one rate."""
    coherent: float = 0.5
    """Share of a line's power with one phase to the drive torque, below which that phase does not count."""
    phase_by_chance: float = 0.01
    """Chance that a phase which is none is taken for one."""
    many_windows: int = 9
    """Windows less one from which `coherent` alone decides: by chance it is rarer still."""
    hann_bins: float = 1.5
    """Bins of a Hann window that count as one."""


@dataclass(frozen=True)
class ResidualRules:
    """How a residual or a score is read."""

    noise_errors: float = 4.0
    """Standard errors up to which chance explains a residual above the floor. Of records of 1 000 to 10 000 samples of
    white noise 2 to 5 in 1000 are above, not one in 30 000 as for the normal law: the floor is the least of several
    readings where one is significantly lower."""
    readings_agree: float = 1.5
    """Ratio of two readings of a noise below which they agree."""
    white: float = 0.9
    """Share of effective samples below which residuals are called coloured."""
    ample: float = 40.0
    """Samples a fitted number below which AIC and BIC, which hold for many, are rough (Burnham and Anderson)."""


RESONANCE = ResonanceRules()
ORDER = OrderRules()
RESIDUAL = ResidualRules()
