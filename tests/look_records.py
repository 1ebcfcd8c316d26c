"""Records for a look: lines of a step rate, hum and noise, each of a known size."""

import numpy as np

RATE_HZ = 2000.0
TIME = np.arange(20_000) / RATE_HZ
NOISE = 0.003
STEPS = 41.0
LINES = {0.5: 0.02, 1.0: 0.3, 2.0: 0.1, 3.0: 0.05}
"""Amplitudes in N m by order of the step rate."""
HUM_HZ, HUM = 50.0, 0.02


def torque(seed=1, rate=STEPS):
    """Return lines of a step rate, hum, and noise."""
    rng = np.random.default_rng(seed)
    y = sum(a * np.sin(2.0 * np.pi * order * rate * TIME) for order, a in LINES.items())
    return y + HUM * np.sin(2.0 * np.pi * HUM_HZ * TIME) + NOISE * rng.standard_normal(TIME.size)


def written(path, *columns, header="time_s,torque_Nm"):
    """Write columns beside the time as text, and return the path."""
    rows = "".join(",".join(f"{value:.7g}" for value in row) + "\n" for row in zip(TIME, *columns, strict=True))
    path.write_text(f"{header}\n{rows}")
    return path
