"""A structure of three modes known in closed form, one of them a rigid body."""

import numpy as np

FREQUENCY_HZ = np.array([0.0, 18.0, 61.0])
DAMPING = np.array([0.0, 0.01, 0.005])
INTERFACE = np.array([0.05, 0.2, -0.1])
LINE_OF_SIGHT = np.array([[0.05, -0.12, 0.02], [0.0, 0.03, 0.07]])
TRANSLATION, TILT = np.array([0.3, -0.2, 0.1]), np.array([0.05, 0.02, -0.07])
"""Shapes at the interface along two further directions, tx and ry."""
NAMES = ("los_x", "los_y")


def receptance(frequency_hz):
    """Return the sum over modes written out, (n, 3): interface, los_x, los_y."""
    w = 2.0 * np.pi * np.asarray(frequency_hz)
    total = np.zeros((w.size, 3), dtype=complex)
    for k in range(3):
        w_k = 2.0 * np.pi * FREQUENCY_HZ[k]
        gain = INTERFACE[k] / (w_k**2 - w**2 + 2j * DAMPING[k] * w_k * w)
        for row, shape in enumerate((INTERFACE, *LINE_OF_SIGHT)):
            total[:, row] += shape[k] * gain
    return total
