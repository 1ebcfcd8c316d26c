"""Emission of a held-out run: RMS torque and the amplitudes at multiples of the step rate."""

import numpy as np

from .tasks import ORDERS

RATE_HZ = 10_000.0
WINDOW_S = (1.0, 2.0)
"""Part of a run that is judged; the start transient has decayed by then."""


def emission_of(torque: np.ndarray, rate: float) -> dict[str, float | list[float]]:
    """Return ``{"rms_Nm": ..., "lines_Nm": [...]}`` of a run's torque.

    Parameters
    ----------
    torque : (N,)
        Torque in N m, a sample every 1/RATE_HZ s from the start of the command on, at least to the window's end.
    rate : float
        Full steps per second.

    Raises
    ------
    ValueError
        The torque ends before the window does.

    Notes
    -----
    A constant and sine and cosine of every order are fitted together to the samples of the window by least squares;
    a line is the amplitude (peak) of its pair. The RMS is that of the samples less their mean.
    """
    first, last = (round(end * RATE_HZ) for end in WINDOW_S)
    if torque.size < last:
        raise ValueError(f"the torque has {torque.size} samples, the window ends at sample {last}")
    y, t = torque[first:last], np.arange(first, last) / RATE_HZ
    turns = 2.0 * np.pi * rate * np.outer(t, ORDERS)
    basis = np.hstack([np.ones((y.size, 1)), np.cos(turns), np.sin(turns)])
    found = np.linalg.lstsq(basis, y, rcond=None)[0][1:]
    lines = np.hypot(found[: len(ORDERS)], found[len(ORDERS) :])
    return {"rms_Nm": float(np.std(y)), "lines_Nm": [float(line) for line in lines]}
