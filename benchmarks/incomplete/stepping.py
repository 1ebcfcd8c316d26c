"""A command as a campaign file writes it, and its step edges and phase voltages, worked out by hand.

Independent of `mechid.command`: rates are positive and rise or stay, which is all that these benches use.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

STEPS = {"full": 1, "half": 2}


def edges(command: Mapping[str, Any], seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the instants at which the voltages change, (E,) s, and the normalised voltages from each on, (E + 1, 2).

    The first row is what the coils hold before the first step. Step k comes when the integral of the rate reaches
    k/n, its voltages are -cos and sin of the start angle plus k 90 deg/n, or row k of the command's table.
    """
    n = STEPS.get(command["stepping"]) or int(command["microsteps"])
    times = np.concatenate(list(_instants(_pieces(command, seconds), n)) or [np.empty(0)])
    if (table := command.get("table")) is not None:
        return times, np.take(table, np.arange(times.size + 1), axis=0, mode="wrap")
    angle = math.radians(command.get("start_angle_deg", 0.0)) + np.arange(times.size + 1) * (0.5 * math.pi / n)
    return times, np.stack([-np.cos(angle), np.sin(angle)], axis=1)


def _pieces(command: Mapping[str, Any], seconds: float):
    """Yield (start s, end s, rate at the start, rate at the end) of the pieces of linear rate, steps/s."""
    points = command.get("rate_profile") or [[0.0, command["rate"]]]
    before = [0.0, points[0][1]]
    for time, rate in [*points, [math.inf, points[-1][1]]]:
        end = min(time, seconds)
        if end > before[0]:
            slope = 0.0 if math.isinf(time) else (rate - before[1]) / (time - before[0])
            yield before[0], end, before[1], before[1] + slope * (end - before[0])
        before = [time, rate]


def _instants(pieces, n: int):
    """Yield the instants of the steps in each piece, s: the roots of position = k/n."""
    position = 0.0
    for start, end, first, last in pieces:
        length = end - start
        reached = position + 0.5 * (first + last) * length
        k = np.arange(math.floor(position * n + 1e-9) + 1, math.floor(reached * n + 1e-9) + 1)
        way = k / n - position
        acceleration = (last - first) / length
        yield start + 2.0 * way / (first + np.sqrt(first**2 + 2.0 * acceleration * way))
        position = reached
