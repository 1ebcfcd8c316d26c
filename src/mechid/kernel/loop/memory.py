"""What the time loop knows and keeps.

It knows no physics, only states, guards, edges and samples. One text serves all plants.
"""

from __future__ import annotations

from mechid.kernel.loop.plant import INNER, MOST_GUARDS, NG, NS, NSEED, NY, Numbers, njit

OK, DIVERGED, CHATTER = 0, 1, 2
NEXT_SAMPLE, EDGE, EVENTS, STALE, ROWS, MODE = 0, 1, 2, 3, 4, 5  # places in `discrete`; modes, then armed guards
ARMED = MODE + NS
GROUPS = ARMED + NS * MOST_GUARDS  # what moves in each group of lanes
OWN = GROUPS + NG  # whether a group moves parameters of the filter
LAYERS = OWN + NG  # first layer of each group, and end of the last one's; `lay_directions` fills them
# Of each layer: its rows, the coefficients of its four lanes, whether it adds to another.
LAYER, LAYER_SIZE = LAYERS + NG + 1, 6
DISCRETE = LAYER + LAYER_SIZE * NG * NSEED
GRID_START, GRID_INTERVAL, GRID_STEP, GRID_CLOSE = 0, 1, 2, 3  # places in `grid`
EVENT_TIME, EVENT_SWITCH, EVENT_BEFORE, EVENT_AFTER, EVENT_SLOPE, EVENT_RISE = 0, 1, 2, 3, 4, 5  # and of an event
EVENT_LANES = EVENT_RISE + NY
LARGE = 1e9  # a measured quantity beyond this has diverged
MOST_EVENTS = 64  # in one step
THROWN = 1e-9  # a margin this far below zero, of its change over a step, did not come there by flowing
AHEAD = 0.01  # of a sample interval, to see which way a motion begins
SAME = 1e-8  # steps that differ by less of the longest one are of one length; late in a record time itself is rounded
CLOSE_SAMPLES = 100  # close behind the start, or behind a switch into a mode of its guard's own choice, a break-away
REFRESH = 256  # samples after which sines and cosines are taken afresh


@njit(**INNER)
def fill(w: Numbers, first: int, last: int, value: float) -> None:
    """Set w[first:last]."""
    for i in range(first, last):
        w[i] = value
