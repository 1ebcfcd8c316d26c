"""Thresholds for the detection of a file's clock and of a record's step rate."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ClockRules:
    """Detection of a regular clock, its unit and its gaps."""

    jitter: float = 1e-3
    """Maximum deviation of a time stamp from a regular clock, in sample intervals."""
    jitter_of_rounded: float = 0.25
    """The same for stamps printed with too few digits."""
    most_rounded: float = 0.2
    """Maximum rounding error of floating point, in units of a digit, for the digit to be significant."""
    whole_rate: float = 1e-6
    """Relative tolerance for rounding a rate to a whole number of hertz."""
    shortest_s: float = 1e-12
    """Minimum sample interval, far below that of any recorder."""
    longest_s: float = 1e12
    """Maximum sample interval."""
    most_stamps: int = 2**21
    """Number of first stamps used for the usual interval."""
    most_jitter: float = 0.5
    """Maximum deviation of a stamp, in sample intervals, for its sample to be assigned unambiguously."""
    first_stamps: int = 512
    """Number of stamps at the beginning of the search for the interval, which is extended from there."""
    refits: int = 3
    """Number of line fits before each extension, each with positions from the previous line."""
    interval_range: float = 0.1
    """Relative half-width of the search range around the median interval."""
    interval_trials: int = 1001
    """Number of trial intervals in that range."""
    gap: float = 2.5
    """Distance of two stamps, in median intervals, beyond which samples are missing between them."""
    most_missing: int = 100
    """Maximum number of clock instants per sample of the file."""
    always_placed: int = 2**20
    """Number of instants up to which that limit does not apply."""
    same_increment: float = 1e-9
    """Relative difference of two intervals that are considered equal."""
    stamp_s: float = 2e-6
    """Rounding error of the difference of two stamps with a resolution of microseconds."""
    fastest_hz: float = 1e6
    """Maximum rate for numbers without a unit to be seconds; torque is recorded at kilohertz."""
    fastest_from_date_hz: float = 1e5
    """The same if the first number may be a date in days."""
    round_rate: float = 1e-4
    """Relative tolerance of a whole rate in Hz, or a whole interval in s, as set by users."""
    most_digits: int = 12
    """Maximum number of digits of a stamp."""
    fast_for_days_hz: float = 1e3
    """Least rate, if read in seconds, for which days are tried: 1 kHz would be one stamp per 86 s."""


@dataclass(frozen=True)
class StepRateRules:
    """Detection of a record's step rate from spectral lines, or from a ridge in the spectrogram."""

    strongest: int = 12
    """Number of the strongest lines whose integer fractions are tried as repetition frequency."""
    lowest: int = 4
    """Number of the lowest lines that are tried likewise."""
    parts: int = 8
    """Largest denominator of the fractions."""
    near_bins: float = 0.35
    """Tolerance of a multiple in bins."""
    steady: float = 2e-4
    """Tolerance of a multiple relative to the frequency."""
    least_bins: float = 3.0
    """Least repetition frequency in bins; below, any line would be near a multiple."""
    explained: float = 0.95
    """Least share of the lines, weighted by the logarithm of their ratio, that are multiples."""
    wandering: float = 3e-3
    """Value of `steady` for a rate that fluctuates."""
    most_power: float = 0.9
    """Least share of the lines' power in multiples of such a rate."""
    mostly_explained: float = 0.6
    """Value of `explained` for such a rate."""
    fewest: int = 3
    """Minimum number of lines."""
    by_chance: float = 5.0
    """Least improbability, in decades, of as many lines being near multiples by chance."""
    contrast: float = 2.0
    """Least ratio of the median amplitudes of even and odd multiples."""
    repeats: int = 4
    """Maximum period in full steps; after four the coils carry the same currents again."""
    settles: float = 1e-3
    """Shift of a motor relative to its command, in steps, while the motion of a record settles."""
    frequency_error: float = 0.7
    """Standard error of a line's frequency in bins, relative to its relative amplitude error."""
    least_error: float = 2e-2
    """Least standard error of a line's frequency in bins, caused by the start of the motor."""
    readable: tuple[float, ...] = (0.25, 0.5, 1.0, 2.0, 4.0)
    """Possible periods of a record at the declared rate, in full steps."""
    off: float = 0.01
    """Relative tolerance of these periods."""
    window_s: float = 0.5
    """Default window of the spectrogram."""
    windows: int = 120
    """Default number of windows."""
    fewest_windows: int = 16
    """Minimum number of windows; they are shorter for a short record."""
    fastest_hz: float = 400.0
    """Maximum frequency at the ends of a ridge."""
    trials: int = 101
    """Number of trial frequencies for each end of a ridge."""
    lowest_bins: int = 4
    """Number of lowest bins that are ignored, because lines cannot be separated from drift there."""
    stands_out: float = 1.0
    """Least power of a ridge over the window's median, in decades."""
    mostly: float = 0.6
    """Least share of windows with that power."""
    swept: float = 0.2
    """Least change of the rate along a ridge, relative to its largest rate; below, the rate is constant."""


STAMPS = ClockRules()
STEP_RATE = StepRateRules()
