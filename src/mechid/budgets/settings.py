"""Settings of the budget: periodic motions and their lines, levels and their draws, residual torque."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MotionSettings:
    """Settings of the search for a steady motion at a rate, and of its lines."""

    # Lines, held against long direct simulations (docs/budget.md).

    promised: float = 1e-8
    """Error of a line, as a share of the largest, above which samples and steps are doubled."""
    power: float = 2e-4
    """Relative change of the mean square above which they are doubled; jumps between samples leave it."""
    relative: float = 1e-4
    """Relative accuracy of a line above the floor."""
    verified: float = 1e-5
    """Size of a line, as a share of the largest, down to which lines have been compared with the simulations."""
    most_doublings: int = 3
    """Doublings of samples and steps."""
    decayed: float = 25.0
    """Time constants after which the initial state of the filter is gone: 1e-11 of it is left."""
    endless: float = 1e-11
    """Decay rate, as a share of a filter's fastest root, below which rounding hides whether a root decays at all."""
    safety: float = 2.0
    """Factor from the RMS difference of two resolutions to the error of a line."""
    neighbours: int = 4
    """Lines on both sides over which that RMS is taken: the difference of a single line may be 0."""
    kept_line: float = 1e-5
    """Size, as a share of the largest, below which lines between the multiples of half the step rate are left out."""
    pieces: int = 8
    """Pieces of a stretch of a motion that does not repeat, whose scatter gives the error of its lines."""

    # Harmonics that do not repeat with the steps, held against direct simulations (docs/budget.md).

    quick_s: float = 4.0
    """Period above which a harmonic is left to the linear response, where any has to be: long periods take long."""
    linear: float = 0.1
    """Share of their torque that the linear response may miss."""
    whole_cycles: float = 1e-6
    """Distance from a whole number of cycles within which a harmonic repeats."""
    digits: int = 9
    """Digits to which two orders have to agree to be one."""

    # The orbit: Newton's method on the state after a period.

    most_periods: int = 4
    """Periods after which a motion that has not repeated counts as one that does not repeat."""
    iterations: int = 8
    """Newton steps."""
    closed: float = 1e-9
    """Newton step, in the states' own sizes, after which no further one is taken."""
    shrinks: float = 0.7
    """Ratio of a Newton step to the one before above which the iteration is abandoned."""
    reach: float = 0.2
    """Error of the linear map up to which its fixed point is the motion that the simulated state approaches."""
    integrated: float = 1e-7
    """Integration error, in the states' own sizes, between a period begun anew, in finer steps at first, and one passed
    on the way."""
    little: float = 0.1
    """Share of a distance that is left when the simulated state has been followed far enough."""
    most_followed: int = 10
    """Times round over which it is followed at most."""
    neutral: float = 1e-9
    """Distance from 1 within which a multiplier counts as neutral."""
    same_motion: float = 1e-6
    """Distance of two states, in their own sizes, within which their motions are one."""
    most_motions: int = 4
    """Steady motions that are looked for at a rate."""

    # Simulation of a period.

    sample_rate_hz: float = 10_000.0
    """Least sample rate."""
    above_cut_off: float = 10.0
    """Least ratio of the sample rate to the highest frequency of a line: components that alias to a line lie nine times
    higher, where the anti-alias filter passes 1/9^8."""
    looks: int = 16
    """States sampled in a period for their range."""
    longest_s: float = 120.0
    """Period above which a motion is taken as one that does not repeat."""
    least_s: float = 0.5
    """Length of the stretch that is shown of a motion that repeats."""
    endless_s: float = 4.0
    """Length of the stretch of one that does not: its lines and its power have a sampling error."""
    rounds: int = 3
    """Times that a motion is simulated for `settle_s` until it repeats, or is taken as one that does not."""
    slow: float = 0.25
    """Share of the settling time: a transient that decays no faster is still there when the motion counts as steady."""


@dataclass(frozen=True)
class LevelSettings:
    """Numbers of draws and instants for levels; each error that they cause is reported or far below the level."""

    points: int = 8192
    """Instants at which the sum of the sources is looked at; a level is good to some 1e-4 with one source."""
    quick_points: int = 1024
    """Instants of a level where many are compared; all have the same, so that their differences are good."""
    least_points: int = 2001
    """Least points of a flat density over frequency."""
    periods: int = 99_991
    """Periods over which the instants spread where lines lie between the multiples of a source's frequency: a prime, so
    that the phases in a period stay evenly spread."""
    points_a_lobe: int = 40
    """Points between the zeros of an index's weight."""
    cone_draws: int = 16
    """Draws of the random part for each instant of the periodic one."""
    replicas: int = 16
    """Independent draws of the whole ensemble: their differences give the sampling error."""
    members: int = 128
    """Members of each replica, a power of two for Sobol's sequence; also the instants kept of each member, which have
    to divide `quick_points`."""
    stretch: float = 2.0
    """Factor by which members are drawn farther out along the direction in which they get worse, with less weight: 7 %
    of them are then beyond three standard deviations, not 0.1 %."""
    stretch_across: float = 0.5
    """Excess over 1 shared by all other directions: the worst of two equal biases at right angles are on a circle."""
    missed_draws: int = 128
    """Draws of the model discrepancy."""
    share_draws: int = 512
    """Draws of the variance shares, a power of two for Sobol's sequence."""
    samples: int = 200
    """Parameter samples at each rate, and over a profile."""
    limits95: tuple[float, float] = (0.025, 0.975)
    """Quantiles of an interval of 95 %."""
    bound: float = 0.95
    """Probability with which an amplitude stays below its bound."""
    quiet: float = 1e-4
    """Size, as a share of the largest, below which levels leave a line out; all such lines are far below the bands."""
    line_spacing: float = 0.5
    """Spacing of the model's lines, as a multiple of the step rate, which a density is divided among."""
    slices: int = 6000
    """Slices of a density over frequency, in equal ratios: a resonance of 0.5 % damping is a dozen of them wide."""
    not_steady: float = 1e-3
    """Share of the RMS that does not repeat from which it counts as a random part."""
    samples_a_period: float = 8.0
    """Samples of the line of sight that are kept in a period of the highest frequency that counts."""
    windows: int = 400
    """Most windows over a profile in which the RMS is taken."""
    course_samples: int = 4000
    """Samples of a profile's line of sight: the least and the largest of each of half as many stretches."""
    campbell_orders: tuple[float, ...] = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 16.0)
    """Lines a full step whose crossings with modes are listed."""
    rates_at_crossing: tuple[float, ...] = (-0.01, -0.003, 0.0, 0.003, 0.01)
    """Rates added at a crossing, relative to it: a mode of 0.5 % damping is 1 % wide."""
    around_rates: float = 0.05
    """Relative distance outside the rates up to which crossings are listed."""


@dataclass(frozen=True)
class ResidualRules:
    """Rules for using the residual of a fit as a source in flight, and for its transfer."""

    noise_error: float = 3.7
    """Relative standard error of residual power over noise power, times the root of the samples: sqrt(2) of the one and
    2 x 1.7 of the other (`signal.noise`), by their squares."""
    width: float = 0.12
    """Relative half-width over which the bench's response is a root mean square, as the residual is that of
    neighbouring rates; where a response passes through zero, the residual there does not show its source."""
    agree: float = 0.1
    """Difference of both ratios up to which the path is known."""
    suffices: float = 0.05
    """|R K| up to which the one-way torque is enough."""
    false_alarm: float = 0.01
    """Chance that a complete model's noise makes a source at one rate that flies, at any order or band."""
    sigmas: float = 4.0
    """Standard errors of the noise floor by which a density has to exceed it, beside its own scatter."""
    near: float = 0.12
    """Relative difference up to which a rate of the bench is near."""
    fewest: int = 4
    """Rates whose residual counts, the nearest, where fewer are near."""
    along: float = 1e-3
    """Difference in each cosine up to which the bench's drive axis is the structure's axis."""
    rounding: float = 1e-6
    """Cosine below which one is zero."""
    uncovered: float = 0.05
    """Share of a torque outside the band of the structure from which a finding names it."""
    unsteady: float = 0.05
    """Share of a torque that does not repeat with the steps from which a finding names it."""


MOTION = MotionSettings()
LEVEL = LevelSettings()
RESIDUALS = ResidualRules()
