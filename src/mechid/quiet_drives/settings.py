"""Settings of quiet drives: periodic torque, cost, search and rounding of a table, step reserve, survey of rates."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class QuietSettings:
    """Settings of the table search and of the survey; docs/quiet.md states the measurements behind them."""

    # Periodic torque.

    settle_s: float = 0.6
    """Time that is simulated before each attempt to find the periodic motion."""
    attempts: int = 3
    """Attempts to find it."""
    averaged_s: float = 1.0
    """Length over which the power of a motion that does not repeat is averaged."""
    most_averaged: int = 40
    """Periods that this length holds at most."""
    change: float = 1e-4
    """Change of a table value, as a share of the peak, from which a derivative is taken: the kernel integrates to 1e-8,
    and the torque is smooth in the table between stick-slip events."""
    highest_hz: float = 2000.0
    """Highest line that counts, as in the budget."""

    # Cost of a table.

    near: tuple[float, ...] = (0.8, 0.9, 1.1, 1.2)
    """Rates beside a design rate that count too, relative to it: the improvement has to hold over +-20 %."""
    near_weight: float = 0.3
    """Weight of these rates."""
    same_rate: float = 0.03
    """Relative distance within which two rates are one place of the cost."""
    least_line: float = 2e-4
    """Amplitude, as a share of the largest line, below which a line counts as this share: a line that the nominal table
    hardly excites needs no further reduction."""
    limit_weight: float = 20.0
    """Weight of the excess over `allowed_rise` at a rate of the range."""
    allowed_rise: float = 1.06
    """Level relative to that of the nominal table that the search allows: half of the 1 dB that is promised."""
    pull: float = 0.05
    """Weight of the level at the rates of the range, so that it is lowered where this costs nothing."""
    broken_pull: float = 1.0
    """The same at a rate at which simulation found a level beyond the allowed one."""
    roughness: float = 1e-3
    """Weight of the second difference of the table's change over the electrical angle."""
    peak_weight: float = 50.0
    """Weight of an excess over the peak limit."""
    range_rates: int = 14
    """Rates of the range in the cost, in equal ratios."""
    draws: int = 4
    """Mechanisms drawn from the covariance that count at the design rates, beside the nominal one."""

    # Search.

    iterations: int = 12
    """Linearisations of the lines at most."""
    damping: float = 1e-3
    """First damping of a step, relative to the curvature of the cost."""
    ridge: float = 1e-9
    """Least damping of a direction on which no line depends, relative to the mean curvature."""
    slack: float = 1.001
    """Factor on a limit within which the search moves: the nominal table stands on its peak, where a barrier has no
    room. A table beyond the peak is made smaller as a whole when the search has ended."""
    inside: float = 1.00001
    """Room of a table that stands on this limit or beyond it, as a factor."""
    first_barrier: float = 1e-3
    """First weight of the barriers, as a share of the design cost."""
    last_barrier: float = 1e-8
    """Weight below which the search within a linearisation ends."""
    barrier_ratio: float = 0.1
    """Ratio of a weight to the one before."""
    newton_steps: int = 30
    """Newton steps at each weight at most."""
    newton_converged: float = 1e-6
    """Expected relative decrease below which they end."""
    shortest: float = 1e-8
    """Shortest part of a Newton step that is tried."""
    largest_damping: float = 1e6
    """Damping above which no step is tried."""
    raised: float = 5.0
    """Factor on the damping after a step that failed; its inverse after one that succeeded."""
    converged: float = 0.05
    """Relative decrease of the cost below which the search ends."""
    rounds: int = 3
    """Searches, each with the rates added at which the table before was louder than allowed."""
    raised_limit: float = 3.0
    """Factor on the weight of the limit at an added rate."""
    checked_rates: int = 40
    """Rates of the range at which a table is checked."""
    promised_rise_db: float = 1.0
    """Largest rise of the level over that of the nominal table."""
    highest_harmonic: int = 31
    """Highest harmonic of the electrical angle in a table, if the microsteps resolve it."""

    # Rounding.

    sweeps: int = 20
    """Moves of the descent, in multiples of the entries."""
    linearisations: int = 3
    """Linearisations of the lines, each about the last rounded table."""
    orders_tried: int = 40
    """Orders of the entries in which they are rounded; the first is that of the table."""
    descents: int = 4
    """Of them, the best ones from which the descent starts."""
    nearness: tuple[float, ...] = (1e-5, 1e-4, 1e-3, 1e-2)
    """Weights of the distance from the exact table that are tried."""
    range_weights: tuple[float, ...] = (0.05, 0.1, 0.2, 0.3, 0.5)
    """Weights of the range's levels that are tried, in place of their limits; 1 alone lost 12 dB where these lose 2."""
    codes_simulated: int = 8
    """Tables of codes of each linearisation that are simulated, those of least linearised cost."""

    # Step reserve.

    reserve_ramp_s: float = 0.4
    """Time in which a run rises to the rate."""
    reserve_levels: int = 10
    """Levels up to the holding torque of which the largest that holds is looked for, before bisection."""
    tightenings: int = 3
    """Searches with a larger fundamental until the reserve is kept."""
    tightened: float = 1.3
    """Factor on the rise of the fundamental: the reserve falls more than the fundamental does."""
    reserve_s: float = 0.5
    """Time for which a rate is held to find its torque reserve."""
    reserve_resolution: float = 0.01
    """Resolution of a torque reserve, as a share of the holding torque."""
    blend: float = 0.02
    """Resolution of the share of the change that is kept if the reserve would fall below its limit."""

    # Survey.

    survey_rates: int = 30
    """Rates of the range, in equal ratios."""
    survey_draws: int = 6
    """Mechanisms drawn from the covariance."""
    quantile: float = 1.645
    """Standard deviations above the mean of the drawn levels at which the bound is, 95 % one-sided."""
    quiet_quantile: float = 0.25
    """Quantile of the bounds over all rates and steppings up to which a rate is recommended."""
    loud_ratio: float = 2.0
    """Ratio to the median bound above which a rate is forbidden, where no limit is given."""
    confirmed_db: float = 1.0
    """Error of the RMS torque that a confirming record may leave."""
    two_sided: float = 1.96
    """Standard deviations of a two-sided error at 95 %."""
    longest_confirming_s: float = 3600.0
    """Length above which a confirming record is called too long."""
    most_uncovered: float = 0.05
    """Share of the RMS torque at frequencies that the structure does not cover, above which this is said."""
    most_bands: int = 5
    """Bands of a verdict that are listed."""
    sensitivity_sigmas: float = 2.0
    """Standard errors by which a parameter is changed to find the sensitivity of the improvement."""


QUIET = QuietSettings()
