"""Steady states made by hand, of which a test says no more than it needs."""

import numpy as np

from mechid.budgets.steady_state import SteadyState


def state_by_hand(rate, orders, lines, **known):
    """Return a motion that repeats, with lines of the torque (N m) at multiples of half the rate (full steps/s)."""
    n, nothing = len(lines), np.zeros(100)
    own = {
        "steps": 2,
        "periods": 1,
        "gradient": np.zeros((n, 0), dtype=complex),
        "error": np.zeros(n),
        "sample_rate_hz": 1000.0,
        "samples_a_period": 100.0,
        "rms": 0.0,
        "rms_error": 0.0,
        "x": np.zeros(0),
        "multipliers": np.zeros(0, dtype=complex),
        "follows": True,
        "size": np.zeros(0),
    }
    whole = {"orders": np.array(orders), "lines": np.array(lines, dtype=complex)}
    return SteadyState(rate=rate, torque=nothing, residual=nothing, **(whole | own | known))
