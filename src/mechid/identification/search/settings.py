"""Settings of the search: starts in a box, first moments, gated growth, and the joint solver."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SearchSettings:
    """Thresholds and sizes of the search for a point near the optimum.

    With the values of the first two groups, `make recovery` finds 100 of 100 random mechanisms. None was varied on its
    own there, unless its line says so.
    """

    # Starts, judged in the first moments of each record.

    points: int = 2048
    """Points of the box."""
    starts: int = 16
    """Points that are refined."""
    more_starts: int = 64
    """Points that are refined if neither the first ones nor a single effect explains the first moments. Two complete
    benches of 30 (family 2, seeds 110 and 111) had their answer among points 17 to 64, none among 16 of other seeds."""
    batch: int = 4
    """Starts that are refined together; in most cases the first batch contains the answer."""
    robust_steps: int = 24
    """Robust solver steps of a start."""
    further_steps: int = 48
    """Robust solver steps of a start that was not good enough after the first ones."""
    robust_sigmas: float = 20.0
    """Residual at which the soft loss bends, in sigmas."""
    explained: float = 1.1
    """Robust cost a sample, in sigmas squared, below which a start explains the first moments: with the missing effect
    free 0.97 to 1.1 remains, without it 2 to 25 (docs/identification.md)."""
    first_window_s: float = 0.06
    """Part of each record in which starts are judged."""

    # Gated growth.

    gate_window_s: float = 0.005
    """Window whose mean squared residual stays below `gate_limit` where the model follows a record."""
    gate_limit: float = 4.0
    """Largest mean squared residual of a gate window that counts as followed, in sigmas squared."""
    beyond_s: float = 0.08
    """Time past the horizons over which escapes are judged."""
    rounds: int = 80
    """Largest number of rounds of a growth."""
    escape_draws: int = 32
    """Draws of an escape at each width."""
    escape_winners: int = 3
    """Draws at each width that are refitted."""
    moves: float = 8.0
    """Deviation from rest that counts as motion, in sigmas."""
    floor_s: float = 0.015
    """Rest with which a channel is compared. A window that contains less motion than this begins later."""
    lead_s: float = 0.005
    """Rest that a later window includes before the motion, so that a start that moves too early costs something."""
    run_up_steps: float = 8.0
    """Full steps before the first sample from which the model is stepped. Three cut records are found within 0.8
    standard errors from 20 % off (docs/identification.md, Starts)."""
    run_up_s: float = 0.3
    """Shortest time of that run-up; found with it."""

    # Leaps and retreats of a stalled growth. With these a prototype followed 16 of 16 benches of another generator.

    leap_horizons: int = 8
    """Length that a leap examines, in horizons."""
    leap_windows: int = 100
    """Least number of windows after the horizon that a leap examines."""
    leap_lost: float = 0.6
    """Share of these that may be lost."""
    leap_gain: float = 1.02
    """Factor by which a leap must lengthen the sum of the horizons."""
    leap_fits: int = 4
    """Fits of one leap: each excludes the windows that are not followed then."""
    leap_steps: int = 4
    """Steps of such a fit."""
    leap_tolerance: float = 1e-5
    """Relative fall of the cost at which such a fit stops."""
    leap_offset: int = 4
    """Least number of windows whose median is the offset of a record while a leap is judged."""
    retreats: tuple[float, ...] = (0.9, 0.6)
    """Shares of their horizons within which the unfinished records count in a retreat."""
    retreat_steps: int = 8
    """Steps of a retreat."""
    retreat_tolerance: float = 1e-7
    """Relative fall of the cost at which these stop."""

    # Masks of single windows of misfit. Their values are choices unless a line says more.

    mask_windows: int = 3
    """Consecutive windows that are masked as one moment, 15 ms: a knock of 5 ms lies in two of them. One more window on
    either side covers its beginning and its end."""
    mask_behind: int = 10
    """Windows after such a moment that the model must follow."""
    mask_runs: int = 3
    """Moments of one record: a more frequent misfit is a deficiency of the model."""
    mask_share: float = 0.01
    """Share of a record that several of them may take."""
    mask_rounds: int = 8
    """Times that a growth continues with further moments masked."""
    mask_leaps: int = 2
    """Leaps and retreats of such a growth, as many as for the mechanism as written."""

    # Bounds of time and memory, and of rounding.

    hum_periods: float = 5.0
    """Periods of the slowest hum line that a rest must contain to show it: 0.1 s determine the amplitude to 0.05 sigma.
    """
    realigned_s: float = 0.25
    """Part of a record from which its delay is determined again: some microsteps of the slowest sweep."""
    realigned_share: float = 0.5
    """Largest cost of another delay, as a share of the cost at the present one. A choice."""
    longest_rest_s: float = 2.0
    """Longest rest after which the window follows the motion. All of it is simulated at each of the 2048 starts: 2 s at
    10 kHz take 3 s of CPU a record."""
    chunk: int = 64
    """Points that are written to the journal together."""
    block: int = 65536
    """Largest number of samples that are compared at once."""
    short_block: int = 1024
    """Samples simulated at once while a horizon is determined: a run that soon loses its record ends soon."""
    negligible_fall: float = 1e-3
    """Fall of the cost, in sigmas squared, that moves no parameter by more than a thirtieth of its standard error."""
    notable_fall: float = 1.0
    """Fall of the cost, in sigmas squared, up to which no parameter moves by more than its standard error."""
    singular: float = 1e-7
    """Share of the largest singular value of the column-scaled Jacobian below which one is rounding. A choice."""

    # The others are choices; no benchmark distinguishes values near them.

    quiet: float = 0.01
    """Share of the variance after the first step below which a record counts as at rest before it."""
    good_cost: float = 2.0
    """Robust cost a sample, in sigmas squared, at which the first window counts as explained."""
    escape_widths: tuple[float, ...] = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
    """Widths of an escape's draws, in standard deviations of the present posterior."""
    start_rounds: int = 12
    """Rounds in which the start state of a record alone is refined."""
    patience: int = 4
    """Rounds without a new furthest reach after which growth tries an escape."""
    electrical_steps: float = 4.0
    """Full steps after which the coils repeat their state: one electrical turn."""
    run_up_tries: int = 32
    """States that are tried if a motion does not become periodic."""
    cliff_shares: tuple[float, ...] = (0.0, 0.25, 0.5, 0.75, 1.0)
    """Shares of the way to the predicted optimum, around which the draws of a cliff are made."""
    cliff_widths: tuple[float, ...] = (0.1, 0.2, 0.4, 0.8)
    """Widths of these draws, in standard deviations."""
    cliff_draws: int = 16
    """Draws at each share and width."""
    cliff_beginnings: tuple[float, ...] = (0.125, 0.25, 0.5, 1.0)
    """Shares of a record that are tried before the next longer one. They only save time."""


SEARCH = SearchSettings()
