"""Thresholds by which the clock of a file and the step rate of a record are read."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ClockRules:
    """What counts as a regular clock, its unit and its gaps."""

    jitter: float = 1e-3
    """Distance of a time stamp from the regular clock, in sample intervals, up to which the clock is regular."""
    jitter_of_rounded: float = 0.25
    """The same where the stamps were printed with too few digits for that."""
    most_rounded: float = 0.2
    """Part of a digit that floating point may take before the digit is lost."""
    whole_rate: float = 1e-6
    """Relative distance within which a rate is a whole number of hertz."""
    shortest_s: float = 1e-12
    """Sample interval below which a clock is refused, far from those of recorders."""
    longest_s: float = 1e12
    """The same, above."""
    most_stamps: int = 2**21
    """First stamps from which a message reads the usual step."""
    most_jitter: float = 0.5
    """Distance of a stamp from a regular clock, in sample intervals, beyond which its sample is not certain."""
    first_stamps: int = 512
    """Stamps that the search for the interval begins with; it grows from there."""
    refits: int = 3
    """Lines fitted before it grows, each to places given by the line before."""
    interval_range: float = 0.1
    """Relative distance from the median interval within which the interval is looked for."""
    interval_trials: int = 1001
    """Trials in that range."""
    gap: float = 2.5
    """Median intervals between two stamps beyond which samples are missing between them."""
    most_missing: int = 100
    """Instants of a clock for each sample of the file, beyond which it is refused."""
    always_placed: int = 2**20
    """Instants up to which a clock is not refused for that."""
    same_increment: float = 1e-9
    """Relative difference of two intervals that is rounding."""
    stamp_s: float = 2e-6
    """Rounding of two stamps that are read in microseconds."""
    fastest_hz: float = 1e6
    """Rate above which numbers without a unit are not seconds: torque is recorded at kilohertz."""
    fastest_from_date_hz: float = 1e5
    """The same where the first number may be a date in days."""
    round_rate: float = 1e-4
    """Relative distance from a whole rate in Hz, or a whole interval in s, within which people have set the clock."""
    most_digits: int = 12
    """Most digits of a stamp."""
    fast_for_days_hz: float = 1e3
    """Rate in seconds above which days are tried: 1 kHz would be one stamp in 86 s."""


@dataclass(frozen=True)
class StepRateRules:
    """When lines, or a ridge, show the step rate of a record."""

    strongest: int = 12
    """Strongest lines whose whole parts are tried as repetition frequency."""
    lowest: int = 4
    """Lowest lines that are tried so."""
    parts: int = 8
    """Whole parts that are tried."""
    near_bins: float = 0.35
    """Distance in bins within which a line is at a multiple."""
    steady: float = 2e-4
    """The same, relative to the frequency."""
    least_bins: float = 3.0
    """Least repetition frequency in bins: below, any line would be at a multiple."""
    explained: float = 0.95
    """Share of the lines, by the logarithm of their ratio, that are multiples."""
    wandering: float = 3e-3
    """`steady` of a rate that wanders."""
    most_power: float = 0.9
    """Share of the lines' power that multiples of such a rate have."""
    mostly_explained: float = 0.6
    """`explained` of such a rate."""
    fewest: int = 3
    """Fewest lines."""
    by_chance: float = 5.0
    """Decades by which it is unlikely that so many lines are that near to multiples by chance."""
    contrast: float = 2.0
    """Amplitude of lines of the step rate over that of the others, in the median."""
    repeats: int = 4
    """Full steps after which a motor repeats itself, at most: its coils carry the same currents again."""
    settles: float = 1e-3
    """Part of a step by which a motor moves against its command while the motion of a record settles."""
    frequency_error: float = 0.7
    """Standard error of a line's frequency in bins, over its relative error in amplitude."""
    least_error: float = 2e-2
    """Least standard error of a line's frequency in bins, by a motor's start."""
    readable: tuple[float, ...] = (0.25, 0.5, 1.0, 2.0, 4.0)
    """Full steps after which a record may repeat itself at the declared rate."""
    off: float = 0.01
    """Relative distance from one of these up to which it does."""
    window_s: float = 0.5
    """Usual window of a ridge."""
    windows: int = 120
    """Usual number of windows."""
    fewest_windows: int = 16
    """Fewest windows, shorter where the record is short."""
    fastest_hz: float = 400.0
    """Highest frequency at which a ridge ends."""
    trials: int = 101
    """Ends of a ridge that are tried."""
    lowest_bins: int = 4
    """Bins of a window in which no line is separate from drift."""
    stands_out: float = 1.0
    """Decades of power of a ridge over the window's median."""
    mostly: float = 0.6
    """Share of the windows in which it stands out so."""
    swept: float = 0.2
    """Rise or fall of a ridge, over its largest rate, below which the rate is constant."""


STAMPS = ClockRules()
STEP_RATE = StepRateRules()
