"""Steadiness of a mode's motions: slow transients, coexisting motions, non-repeating motions, and their warnings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from mechid.budgets.line_of_sight import Response
from mechid.budgets.mode_budget import ModeBudget
from mechid.budgets.settings import MOTION

SHOWN_RATES = 6
"""Largest number of rates in a line; all are in the table and in the files."""


def steadiness(made: ModeBudget) -> dict[str, Any]:
    """Return the results on a mode's steady states: decay of transients at each rate, and rates with several states.

    `slowest` is the rate with the slowest transient, NaN if no motion repeats. `several` lists the rates with more than
    one steady state, with one that repeats only after several periods or never, or in which the rotor does not follow.
    """
    every = [(r.state.decay_s, r.state.rate) for here in made.states for r in here if r.state.periods]
    decay_s, rate = max(every, default=(math.nan, math.nan))
    return {
        "largest_multiplier": [r.state.largest_multiplier for r in made.responses],
        "decay_s": [r.state.decay_s for r in made.responses],
        "slowest": {"rate": rate, "decay_s": decay_s},
        "several": [
            {
                "rate": float(made.mode.rates[k]),
                "differs": bool(made.differing_states(k)),
                "states": [_state(r, made.responses[k]) for r in here],
            }
            for k, here in enumerate(made.states)
            if len(here) > 1 or here[0].state.periods != 1 or not here[0].state.follows
        ],
    }


def _state(response: Response, worst: Response) -> dict[str, Any]:
    s = response.state
    return {
        "reached": list(s.reached),
        "periods": s.periods,
        "largest_multiplier": s.largest_multiplier,
        "decay_s": s.decay_s,
        "follows": s.follows,
        "worst": response is worst,
        "torque_rms_Nm": s.rms,
        "rms_rad": response.whole_rms().tolist(),
    }


def steadiness_words(made: ModeBudget) -> Iterator[str]:
    """Yield the cautions about a mode's steady states that affect its margins."""
    name, every = made.mode.name, [(r.state.rate, r.state) for here in made.states for r in here]
    ratios = {
        at.state.rate: _ratio(at, made.differing_states(k))
        for k, at in enumerate(made.responses)
        if made.differing_states(k)
    }
    if ratios:
        yield (
            f'mode "{name}": at {_list_rates(list(ratios))} the disturbance depends on how the rate was reached, '
            f"by a factor of up to {max(ratios.values()):.2g}; the worse counts"
        )
    divided = sorted({rate for rate, s in every if s.periods > 1 and s.follows})
    if divided:
        rates_words = _list_rates(divided)
        yield f'mode "{name}": at {rates_words} the motion repeats only after several periods, with lines between'
    lost = sorted({rate for rate, s in every if not s.follows})
    if lost:
        yield f'mode "{name}": at {_list_rates(lost)} the rotor does not follow the command, or not from each start'
    slow = sorted({rate for rate, s in every if s.decay_s > MOTION.slow * made.mode.settle_s})
    if slow:
        longest = max(s.decay_s for _, s in every if not math.isnan(s.decay_s))
        yield (
            f'mode "{name}": at {_list_rates(slow)} transients decay in up to {longest:.2g} s; a run shorter than some '
            "times that is not steady"
        )


def _ratio(worst: Response, others: Sequence[Response]) -> float:
    """Return the RMS of the worst steady state over the least of the others, along the largest axis."""
    axis = int(worst.whole_rms().argmax())
    return float(worst.whole_rms()[axis] / min(other.whole_rms()[axis] for other in others))


def _list_rates(rates: Sequence[float]) -> str:
    """Return rates in words.

    Examples
    --------
    >>> _list_rates([23.0, 46.25])
    '23, 46.25 steps/s'
    """
    more = f" and {len(rates) - SHOWN_RATES} further rates" if len(rates) > SHOWN_RATES else ""
    return ", ".join(f"{rate:.5g}" for rate in rates[:SHOWN_RATES]) + f" steps/s{more}"
