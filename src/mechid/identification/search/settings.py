"""Settings of the search: starts in a box, first moments, gated growth, and the joint solver."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SearchSettings:
    """Thresholds and sizes of the search for a point near the optimum.

    With the values of the first two groups `make recovery` finds 100 of 100 random mechanisms. None was varied by
    itself there, unless its line says so.
    """

    # Starts, judged in the first moments of each record.

    points: int = 2048
    """Points of the box."""
    starts: int = 16
    """Points that are refined."""
    batch: int = 4
    """Starts that are refined together; in most cases the first batch holds the answer."""
    robust_steps: int = 24
    """Robust solver steps of a start."""
    further_steps: int = 48
    """Robust solver steps of a start that was not good enough after the first ones."""
    robust_sigmas: float = 20.0
    """Residual at which the soft loss bends, in sigmas."""
    explained: float = 1.1
    """Robust cost a sample, in sigmas squared, below which a start explains the first moments: with the missing effect
    free 0.97 to 1.1 is left, without it 2 to 25 (docs/identification.md)."""
    first_window_s: float = 0.06
    """Part of each record in which starts are judged."""

    # Gated growth.

    gate_window_s: float = 0.005
    """Window in which the mean squared residual stays below a limit where the model follows a record."""
    diverged_at: float = 4.0
    """That limit, in sigmas squared."""
    beyond_s: float = 0.08
    """How far past the horizons escapes are judged."""
    rounds: int = 80
    """Most rounds of a growth."""
    escape_draws: int = 32
    """Draws of an escape at each width."""
    escape_winners: int = 3
    """Draws at each width that are refitted."""
    moves: float = 8.0
    """Deviation from rest that counts as motion, in sigmas."""
    floor_s: float = 0.015
    """Rest that a channel is compared with. A window that holds less motion than this length begins later."""
    lead_s: float = 0.005
    """Rest that a later window keeps before the motion: a start that moves too early must cost something."""
    run_up_steps: float = 8.0
    """Full steps before the first sample from which the model is stepped. Three cut records are found within 0.8
    standard errors from 20 % off (docs/identification.md, Starts)."""
    run_up_s: float = 0.3
    """Shortest time of that run-up; found with it."""

    # Leaps and retreats of a stalled growth. With these a prototype followed 16 of 16 benches of another generator.

    leap_horizons: int = 8
    """Times its horizon that a leap looks at a record."""
    leap_windows: int = 100
    """Windows behind the horizon that it looks at, at least."""
    leap_lost: float = 0.6
    """Share of these that may be lost."""
    leap_gain: float = 1.02
    """Times as many samples as before that a leap has to count."""
    leap_fits: int = 4
    """Fits of one leap: each leaves out what is then not followed."""
    leap_steps: int = 4
    """Steps of such a fit."""
    leap_tolerance: float = 1e-5
    """Relative fall of the cost at which it stops."""
    leap_offset: int = 4
    """Windows, at least, whose median is the offset of a record while a leap is judged."""
    retreats: tuple[float, ...] = (0.9, 0.6)
    """Shares of their horizons within which the unfinished records count in a retreat."""
    retreat_steps: int = 8
    """Steps of a retreat."""
    retreat_tolerance: float = 1e-7
    """Relative fall of the cost at which these stop."""

    # Masks of single windows of misfit. Their values are choices but where a line says more.

    mask_windows: int = 3
    """Windows in a row that are left out as one moment, 15 ms: a knock of 5 ms lies in two of them. One more to either
    side holds its beginning and its end."""
    mask_behind: int = 10
    """Windows behind such a moment that the model has to follow."""
    mask_runs: int = 3
    """Moments of one record: what comes more often is a lack of the model."""
    mask_share: float = 0.01
    """Share of a record that several of them may take."""
    mask_rounds: int = 8
    """Times that a growth goes on with further moments masked."""
    mask_leaps: int = 2
    """Leaps and retreats of such a growth, as many as of the mechanism as written."""

    # Bounds of time and memory, and of rounding.

    hum_periods: float = 5.0
    """Periods of the slowest line of hum that a rest must have to show it: 0.1 s tell the amplitude to 0.05 sigma."""
    realigned_s: float = 0.25
    """Part of a record by which its delay is found anew: some microsteps of the slowest sweep."""
    realigned_share: float = 0.5
    """Share of the cost at the present delay that another one may have at most. A choice."""
    longest_rest_s: float = 2.0
    """Rest up to which the window follows the motion. All of it is simulated at each of the 2048 starts: 2 s at 10 kHz
    take 3 s of CPU a record."""
    chunk: int = 64
    """Points that are noted in the journal together."""
    block: int = 65536
    """Most samples that are compared in one go."""
    short_block: int = 1024
    """Samples simulated in one go while a horizon is sought: a run that loses its record soon ends soon."""
    negligible_fall: float = 1e-3
    """Fall of the cost, in sigmas squared, that moves no parameter by more than a thirtieth of its standard error."""
    notable_fall: float = 1.0
    """Fall of the cost, in sigmas squared, up to which no parameter moves by more than its standard error."""
    singular: float = 1e-7
    """Share of the largest singular value of the column-scaled Jacobian below which one is rounding. A choice."""

    # The others are choices; no benchmark distinguishes values near them.

    quiet: float = 0.01
    """Share of the variance behind the first step below which a record counts as at rest before it."""
    good_cost: float = 2.0
    """Robust cost a sample, in sigmas squared, at which the first window counts as explained."""
    escape_widths: tuple[float, ...] = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
    """Widths of an escape's draws, in standard deviations of the present posterior."""
    start_rounds: int = 12
    """Rounds in which the start of a record alone is refined."""
    patience: int = 4
    """Rounds without a new furthest reach after which growth tries an escape."""
    electrical_steps: float = 4.0
    """Full steps after which the coils are as they were: one electrical turn."""
    run_up_tries: int = 32
    """States that are tried where a motion does not come to repeat."""
    cliff_shares: tuple[float, ...] = (0.0, 0.25, 0.5, 0.75, 1.0)
    """Shares of the way to the promised optimum, around which a cliff's draws are made."""
    cliff_widths: tuple[float, ...] = (0.1, 0.2, 0.4, 0.8)
    """Widths of these draws, in standard deviations."""
    cliff_draws: int = 16
    """Draws at each share and width."""
    cliff_beginnings: tuple[float, ...] = (0.125, 0.25, 0.5, 1.0)
    """Shares of a record that are tried before the next longer one. They save time alone."""


SEARCH = SearchSettings()
