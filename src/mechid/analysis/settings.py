"""Thresholds of the analysis of records and residuals: resonances, orders, lines and noise."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ResonanceRules:
    """Criteria for resonances: peaks over the rate, and humps of a density."""

    alike: float = 0.06
    """Relative distance within which peaks are one resonance."""
    stands_out: float = 2.0
    """Height of the peak of an order over the rate, as a multiple of its surroundings on both sides."""
    above_noise: float = 6.0
    """Height of such a peak above zero, in standard errors."""
    hump_db: float = 3.0
    """Height of a hump of the density above both sides and above the upper half of the band, in dB."""
    smooth: float = 0.03
    """Relative width over which a density is smoothed."""
    points_a_decade: int = 400
    """Frequencies of the smoothed density per decade."""
    line_bins: float = 2.5
    """Bins on both sides that belong to a line under a Hann window."""
    lines_a_hump: float = 4.0
    """Least frequency of a hump of lines, in distances of the lines."""
    wider: float = 0.75
    """Least half-width of such a hump in distances of the lines; narrower humps are single lines."""
    rates_apart: float = 0.1
    """Relative distance above which step rates count as different."""


@dataclass(frozen=True)
class OrderRules:
    """Thresholds for orders of the step rate in records and residuals."""

    window_steps: float = 16.0
    """Length of a window in full steps, if the record is long enough: separates orders that differ by a sixteenth."""
    least_steps: float = 4.0
    """Travel in full steps below which no orders are tracked."""
    highest_share: float = 0.8
    """Share of half the sample rate above which an order is ignored."""
    resolved: float = 3.0
    """Amplitude in standard errors above which a line is resolved, so that amplitude and phase can be compared."""
    one_rate: float = 0.02
    """Relative variation below which the rate of a record counts as constant."""
    rate_step: float = 0.05
    """Relative difference below which windows are assigned to the same rate."""
    bins: int = 64
    """Least number of bins around a line from which the noise level is estimated."""
    fewest_bins: int = 3
    """Least number of bins in a band for an estimate of its density."""
    turns: float = 2.0
    """Least number of turns by which two neighbouring orders differ over a window, for both to be resolved."""
    named_turns: float = 0.9
    """The same number for orders that a mechanism names: sines that differ by a turn over a window are orthogonal, and
    a joint fit needs no more."""
    steady: float = 1e-3
    """Relative variation of the rate below which orders stay at a fixed distance from the hum."""
    hum_apart: float = 2.0
    """Distance in inverse durations above which an order can be separated from a multiple of the mains frequency."""
    hum_room: float = 7.0
    """Distance in inverse durations above which an order is unaffected by lines that follow a frequency drift."""
    quarters: int = 4
    """Denominator of the fractional orders at which a motor has lines."""
    near_bins: float = 0.5
    """Distance in bins within which a line is at a multiple of the step rate."""
    near: float = 5e-4
    """The same distance, relative to the frequency."""
    by_chance: float = 0.2
    """Probability of a match by chance, above which a match is no evidence."""
    false_alarm: float = 0.01
    """Probability of a false line of any component at any order of one rate."""
    coherent: float = 0.5
    """Share of a line's power with a fixed phase to the drive torque, below which the phase counts as unknown."""
    phase_by_chance: float = 0.01
    """Probability of accepting a random phase."""
    many_windows: int = 9
    """Number of windows minus one from which `coherent` alone decides; a match by chance is even rarer then."""
    hann_bins: float = 1.5
    """Correlated bins under a Hann window, which count as one."""


@dataclass(frozen=True)
class ResidualRules:
    """Thresholds for residuals and scores."""

    noise_errors: float = 4.0
    """Excess over the floor in standard errors that chance explains. Of records of 1 000 to 10 000 samples of white
    noise, 2 to 5 in 1000 exceed it, instead of one in 30 000 as for a normal distribution, since the floor is the
    smallest of several estimates if one is significantly lower."""
    readings_agree: float = 1.5
    """Ratio of two noise estimates below which they agree."""
    white: float = 0.9
    """Share of effective samples below which residuals count as coloured."""
    ample: float = 40.0
    """Samples per fitted quantity below which AIC and BIC, which are asymptotic, are rough (Burnham and Anderson)."""


RESONANCE = ResonanceRules()
ORDER = OrderRules()
RESIDUAL = ResidualRules()
