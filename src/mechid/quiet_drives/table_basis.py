"""Microstep tables of one electrical period: nominal values, harmonics, roughness.

Row k of a table holds the phase values at the electrical angle k 90deg/n, as fractions of the peak, in the sense of
u_A = -U cos, u_B = +U sin. If half an electrical period only changes the sign of a mechanism, only odd harmonics keep
its motion repeating after two full steps; a table has even harmonics only where the mechanism needs them.
"""

from __future__ import annotations

import numpy as np

from mechid.arrays import FloatArray
from mechid.command.phase_table import ROWS_A_FULL_STEP, nominal_table


def table_harmonics(microsteps: int, highest: int, *, mirrored: bool) -> FloatArray:
    """Return the changes of a table that a search combines, (m, 4 n, 2): sine and cosine harmonics of each phase.

    Parameters
    ----------
    microsteps : int
        n; harmonics above 2 n are not resolved.
    highest : int
        Highest harmonic of the electrical angle.
    mirrored : bool
        Whether the second half of the period is the first with the opposite sign: odd harmonics only.
    """
    count = ROWS_A_FULL_STEP * microsteps
    angle = 2.0 * np.pi * np.arange(count) / count
    orders = range(1, min(highest, count // 2) + 1, 2) if mirrored else range(min(highest, count // 2) + 1)
    waves = [wave for k in orders for wave in (np.cos(k * angle), np.sin(k * angle)) if np.abs(wave).max() > 1e-9]
    out = np.zeros((2 * len(waves), count, 2))
    for k, wave in enumerate(waves):
        out[2 * k, :, 0] = out[2 * k + 1, :, 1] = wave
    return out


def table_entries(microsteps: int, *, mirrored: bool) -> FloatArray:
    """Return the changes of single entries, (m, 4 n, 2); mirrored entries change with the opposite sign."""
    count = ROWS_A_FULL_STEP * microsteps
    own = count // 2 if mirrored else count
    out = np.zeros((2 * own, count, 2))
    for k in range(own):
        for phase in (0, 1):
            out[2 * k + phase, k, phase] = 1.0
            if mirrored:
                out[2 * k + phase, k + own, phase] = -1.0
    return out


def quarter_wave_harmonics(microsteps: int, highest: int) -> FloatArray:
    """Return changes that keep one quarter wave for both phases, (m, 4 n, 2): b = w(theta), a = -w(theta + 90deg).

    The wave w holds odd sine harmonics only, so that its quarters mirror one another.
    """
    count = ROWS_A_FULL_STEP * microsteps
    angle = 2.0 * np.pi * np.arange(count) / count
    orders = range(1, min(highest, count // 2 - 1) + 1, 2)
    return np.array([np.column_stack([-np.sin(k * (angle + 0.5 * np.pi)), np.sin(k * angle)]) for k in orders])


def fundamental(changes: FloatArray) -> FloatArray:
    """Return the part of tables or changes, (m, 4 n, 2), that turns with the nominal table, (m,); 1 for this table."""
    nominal = nominal_table(changes.shape[1] // ROWS_A_FULL_STEP)
    return np.asarray(np.tensordot(changes, nominal, axes=2) / changes.shape[1], dtype=np.float64)


def roughness(changes: FloatArray) -> FloatArray:
    """Return second differences of changes over the electrical angle, (8 n, m) per rad^2, so that |R c|^2 is a mean."""
    count = changes.shape[1]
    bent = np.roll(changes, -1, axis=1) - 2.0 * changes + np.roll(changes, 1, axis=1)
    flat = bent.reshape(len(changes), 2 * count).T * (count / (2.0 * np.pi)) ** 2
    return np.asarray(flat / np.sqrt(2.0 * count), dtype=np.float64)
