"""Thresholds of signal analysis: noise floors, mains hum, quiet stretches, and how well a model follows a signal."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class FloorSettings:
    """Reading of the noise floor at high frequencies and between impacts."""

    minimum_samples: int = 16
    """Samples below which a series has no floor."""
    lowest: float = 0.6
    """Lower end of the band, as a share of the Nyquist frequency: above most of what mechanisms do."""
    highest: float = 0.98
    """Upper end of the band: clear of the Nyquist frequency, where bins are real and not complex."""
    segments: tuple[int, ...] = (512, 128, 2048)
    """Lengths of the spectra in samples; the first is taken unless another is significantly lower."""
    between_gaps: tuple[int, ...] = (64, 32)
    """Further lengths where there are gaps."""
    enough: int = 8
    """Whole segments of a length, where there are gaps, from which it is used."""
    parts: tuple[int, ...] = (1, 2, 4)
    """Numbers of parts into which the band is cut, in search of a quieter one."""
    significant: float = 3.0
    """Standard errors by which another floor must be lower; otherwise the lowest is so by chance."""
    quiet: int = 8
    """Samples of a window between two impacts: 0.8 ms at 10 kHz."""
    differences: int = 4
    """Order of the differences: they keep the upper half of the band, and 2e-6 of a signal at a hundredth of the sample
    rate."""
    alike: float = 0.1
    """Relative difference beyond chance of the power in a tenth and in a quarter of the windows if both are noise."""
    piece: int = 16384
    """Samples of which differences are made at once."""
    block: int = 256
    """Segments transformed at once: the spectra of a long record are never all in memory."""


@dataclass(frozen=True)
class HumRules:
    """Lines of the electric grid, its frequency and its drift."""

    mains_hz: tuple[float, ...] = (50.0, 60.0)
    """Nominal frequencies of grids."""
    lowest_hz: float = 20.0
    """Lowest multiple that is looked for."""
    highest_hz: float = 1000.0
    """Highest multiple that is looked for."""
    least_ratio: float = 20.0
    """Ratio to the surroundings from which a multiple is a line: hum gave 29 and more, benches without at most 9.4."""
    wander: float = 0.002
    """Relative distance from its nominal frequency at which a grid is looked for."""
    low_multiples: int = 3
    """Lowest multiples: a grid shows its own frequency, or two of these."""
    alike: float = 5e-4
    """Difference of their relative distances from nominal: all are off by the same share."""
    bins: float = 1.5
    """The same as `wander` in bins of a peak, where a short record resolves no better."""
    interpolated: float = 0.35
    """The same as `alike` in bins, of the frequency interpolated between them."""
    off_hz: float = 0.2
    """Distance from its nominal frequency within which the frequency of a grid is estimated."""
    multiples: tuple[int, ...] = (1, 2, 3)
    """Multiples from which it is estimated."""
    by_chance: float = 1e-8
    """Chance that noise alone explains as much as hum that counts as evident."""
    of_its_own: float = 9.0
    """Gain of a frequency of its own for a series: three standard errors."""
    around_hz: float = 2.0
    """Reach of the surroundings of a line."""
    around_bins: float = 20.0
    """The same in inverse durations; the larger of the two counts."""
    fine: int = 8
    """Frequencies looked at in an inverse duration."""
    apart: float = 0.5
    """Distance of the sines that follow a drift, in inverse durations; with three on each side 20 mHz in 60 s leave
    0.3 % of the third multiple."""
    most_beside: int = 10
    """Most sines on each side."""
    shortest_s: float = 8.0
    """Duration from which a drift can be seen."""
    envelope_hz: float = 4.0
    """Sample rate of the slow envelope."""


@dataclass(frozen=True)
class SeriesRules:
    """Quiet stretches, likeness of two series, how far a model follows one, and where its power is."""

    quiet_window_s: float = 0.02
    """Window in which a quiet stretch is looked for."""
    least_samples: int = 16
    """Least samples of such a window."""
    least_windows: int = 3
    """Windows of a quiet stretch; a shorter one may be a signal that passes through zero."""
    far_below: float = 0.1
    """RMS of a quiet stretch, and of the quietest window, over that of the whole series."""
    quiet_alike: float = 2.0
    """RMS of a window over that of the quietest one, up to which it is quiet too."""
    like_the_quietest: float = 1.5
    """RMS of a stretch over that of the quietest one, up to which it is like it."""
    smoothed: int = 3
    """Bins that are summed, so that a line between two of them makes no difference."""
    above_noise: float = 10.0
    """Power over the noise from which bins of two spectra are compared."""
    fewest_bins: int = 4
    """Such bins from which spectra can be compared."""
    lowest_bin: int = 3
    """Bin below which a spectrum shows drift."""
    follow_window_s: float = 0.05
    """Window in which a residual is compared with the measured signal."""
    of_window: float = 0.5
    """Share of the measured RMS in the window up to which a residual follows."""
    of_record: float = 0.125
    """Share of the measured RMS over the record up to which it does in any case."""
    most_of_record: float = 0.5
    """Share of it beyond which it does not."""
    throughout: float = 2.0
    """RMS of a residual in a window over the median of all windows: what is there throughout is not lost."""
    block_windows: int = 128
    """Windows looked at together."""
    most_named: int = 3
    """Lines or bands that are named as the strongest."""
    in_lines: float = 0.5
    """Share of a series' power from which its lines are named and not its bands."""
    least_of_largest: float = 0.1
    """Power over that of the strongest line or band below which one is not named."""
    shortest: int = 64
    """Samples below which none are named."""


FLOOR = FloorSettings()
HUM = HumRules()
SERIES = SeriesRules()
