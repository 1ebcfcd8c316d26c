"""Thresholds of signal analysis: noise floors, mains hum, quiet stretches, and the test of following a signal."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class FloorSettings:
    """Estimation of the noise floor at high frequencies and between impacts."""

    minimum_samples: int = 16
    """Minimum number of samples of a series."""
    lowest: float = 0.6
    """Lower end of the band, relative to the Nyquist frequency: above most of the signals of mechanisms."""
    highest: float = 0.98
    """Upper end of the band: it excludes the Nyquist frequency, whose bin is real rather than complex."""
    segments: tuple[int, ...] = (512, 128, 2048)
    """Segment lengths in samples; the first is used unless another gives a significantly lower floor."""
    between_gaps: tuple[int, ...] = (64, 32)
    """Additional segment lengths for series with gaps."""
    enough: int = 8
    """Minimum number of complete segments of a length, and of windows, for it to be used."""
    parts: tuple[int, ...] = (1, 2, 4)
    """Numbers of sub-bands into which the band is divided, in search of a quieter one."""
    significant: float = 3.0
    """Number of standard errors by which another floor must be lower; the lowest of many is so by chance."""
    quiet: int = 8
    """Length in samples of a window between two impacts: 0.8 ms at 10 kHz."""
    differences: int = 4
    """Order of the differences: they pass the upper half of the band, and 2e-6 of a signal at a hundredth of the sample
    rate."""
    alike: float = 0.1
    """Relative tolerance, beyond chance, between the noise powers inferred from the first decile and quartile."""
    piece: int = 16384
    """Number of samples differenced at once."""
    block: int = 256
    """Number of segments transformed at once, so that the spectra of a long record are never all in memory."""


@dataclass(frozen=True)
class HumRules:
    """Detection of mains lines, and estimation of the mains frequency and its drift."""

    mains_hz: tuple[float, ...] = (50.0, 60.0)
    """Nominal mains frequencies."""
    lowest_hz: float = 20.0
    """Lowest frequency of the search."""
    highest_hz: float = 1000.0
    """Highest frequency of the search."""
    least_ratio: float = 20.0
    """Least power of a line relative to its surroundings: benches with hum had 29 or more, others at most 9.4."""
    wander: float = 0.002
    """Maximum relative deviation of the mains frequency from its nominal value."""
    low_multiples: int = 3
    """Highest of the low multiples; a grid counts as detected by its fundamental or by two of these."""
    alike: float = 5e-4
    """Maximum difference of the relative deviations of multiples, which all share the same deviation."""
    bins: float = 1.5
    """Maximum deviation of a peak in bins; it replaces `wander` for short records."""
    interpolated: float = 0.35
    """Maximum deviation of an interpolated frequency in bins; it replaces `alike` for short records."""
    off_hz: float = 0.2
    """Half-width of the band in which the mains frequency is estimated."""
    multiples: tuple[int, ...] = (1, 2, 3)
    """Multiples used for the estimate."""
    by_chance: float = 1e-8
    """Probability that noise alone passes for hum."""
    of_its_own: float = 9.0
    """Least gain for a separate frequency of a series: three standard errors."""
    around_hz: float = 2.0
    """Half-width of the surroundings of a line."""
    around_bins: float = 20.0
    """The same in inverse durations; the larger value is used."""
    fine: int = 8
    """Number of candidate frequencies per inverse duration."""
    apart: float = 0.5
    """Spacing of the sines that model a drift, in inverse durations; with three on each side, a drift of 20 mHz in 60 s
    leaves 0.3 % of the third multiple."""
    most_beside: int = 10
    """Maximum number of sines on each side."""
    shortest_s: float = 8.0
    """Minimum duration for a drift to be detectable."""
    envelope_hz: float = 4.0
    """Sample rate of the complex envelope."""


@dataclass(frozen=True)
class SeriesRules:
    """Quiet stretches, spectral distance, the test that a model follows a series, and its strongest parts."""

    quiet_window_s: float = 0.02
    """Window of the search for quiet stretches."""
    least_samples: int = 16
    """Minimum number of samples of such a window."""
    least_windows: int = 3
    """Minimum number of windows of a quiet stretch; a shorter one may be a signal that passes through zero."""
    far_below: float = 0.1
    """Maximum RMS of a quiet stretch, and of the quietest window, relative to that of the series."""
    quiet_alike: float = 2.0
    """Maximum RMS of a quiet window, relative to that of the quietest one."""
    like_the_quietest: float = 1.5
    """Maximum RMS of a stretch that is averaged with the quietest one, relative to it."""
    smoothed: int = 3
    """Number of bins summed, so that the position of a line between bins does not matter."""
    above_noise: float = 10.0
    """Least power, relative to the noise, of bins that are compared."""
    fewest_bins: int = 4
    """Minimum number of such bins for a comparison."""
    lowest_bin: int = 3
    """First bin that is used; lower ones are dominated by drift."""
    follow_window_s: float = 0.05
    """Window in which a residual is compared with the measured signal."""
    of_window: float = 0.5
    """Maximum residual RMS, relative to the measured RMS in the window."""
    of_record: float = 0.125
    """Residual RMS that is always accepted, relative to the measured RMS over the record."""
    most_of_record: float = 0.5
    """Upper bound of the tolerance for constant model errors, relative to the measured RMS over the record."""
    throughout: float = 2.0
    """Tolerance for model errors present in all windows, relative to the median residual RMS of the windows."""
    block_windows: int = 128
    """Number of windows processed together."""
    most_named: int = 3
    """Maximum number of lines or bands that are reported as the strongest."""
    in_lines: float = 0.5
    """Share of the power in lines from which lines rather than bands are reported."""
    least_of_largest: float = 0.1
    """Least power of a reported line or band, relative to the strongest one."""
    shortest: int = 64
    """Minimum number of samples for a report."""


FLOOR = FloorSettings()
HUM = HumRules()
SERIES = SeriesRules()
