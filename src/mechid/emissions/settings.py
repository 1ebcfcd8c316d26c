"""Settings of the emission verdict: windows, lines, intervals."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class EmissionSettings:
    """Lengths, levels and thresholds of the emission verdict."""

    least_windows: int = 8
    """Windows without overlap that a record is cut into at least: their scatter is part of a line's interval."""
    stretch_s: float = 2.0
    """Length of the stretches of a record whose rate varies; each is judged at its own mean rate."""
    first_bin: int = 3
    """Lowest bin that is judged: below it Hann's window shows the mean and the drift."""
    least_block: int = 16
    """Fewest bins of a block whose lower quantile is the noise level."""
    block_share: float = 0.1
    """Width of a block over its frequency, so that the level follows coloured noise."""
    quantile: float = 0.3
    """Quantile of a block that is read as noise: lines of a slow rate fill up to half of the bins."""
    by_chance: float = 1e-3
    """Chance that noise alone shows one line in a spectrum."""
    core: int = 3
    """Bins on each side that belong to a line under Hann's window."""
    least_response: float = 0.8488
    """Response of Hann's window half a bin off a line, 8 / (3 pi): the most that a bin without a line can hide."""
    order_step: float = 0.25
    """Orders of the step rate are multiples of it: the currents of a two-phase motor repeat after four full steps."""
    most_order: float = 64.0
    """Highest order that a line is called."""
    near_bins: float = 0.5
    """Distance in bins up to which a line is an order, a multiple of the mains, or that of a background."""
    line_drift: float = 0.25
    """Relative change of a background line from record to record that intervals allow for."""
    above_noise: float = 4.0
    """Power of a background bin over its noise level from which it holds a line."""
    moving_orders: int = 6
    """Whole orders of a step rate at which lines of a background are looked for."""
    moving_least: int = 3
    """Orders found from which a background counts as recorded in motion."""
    groups: int = 600
    """Points of a spectrum that figures show."""


EMISSION = EmissionSettings()


@dataclass(frozen=True)
class BenchSettings:
    """Settings of the correction of a measuring table."""

    most_error: float = 10.0 ** (1.0 / 20.0) - 1.0
    """Relative error of an amplitude of 1 dB, up to which a correction counts as known."""
    coverage: float = 2.0
    """Standard errors of the uncertainty that is compared with it: 95 %."""
    rigid_share: float = 1.0 / 3.0
    """Frequency over that of the first resonance up to which a table adds less than 1 dB: 1 / (1 - 1/9) is 1.02 dB."""
    modal_reach: float = 2.0
    """Highest frequency over that of the highest mode at which modes count: further ones are missing above."""
    roughness_points: int = 9
    """Points over which the roughness of a measured response is averaged."""
    regularisation: float = 0.02
    """Singular value over the largest at rest below which the inverse stops growing: changes others by 0.04 %."""
    arm_m: float = 0.1
    """Length that makes forces of moments, to compare the two: of the size of a table."""
    taper: float = 1.3
    """Frequency over that of the end of a response at which the correction has faded out."""
    resolution_hz: float = 1.0
    """Of the correcting filter, from which its length follows."""


BENCH = BenchSettings()
