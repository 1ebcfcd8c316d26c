"""Measurement of a lab bench: six components of a table, a tachometer, hum, noise, 16-bit steps."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from recovery.campaigns import DRIFT_NM, NOISE_NM, OFFSET_NM

COLUMNS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz", "tacho")
POINT_M = (0.02, 0.0, 0.06)
"""Mounting point of the mechanism, from the table's reference point."""
MAINS_HZ, HUM = 50.02, 2.0
"""Frequency of the mains, and amplitude of its hum in the torque over the noise; a third of it at three times that."""
FORCE_PER_NM, CROSS = {"x": 0.8, "y": -0.5, "z": 0.2}, {"x": 0.06, "y": -0.03}
"""Forces, N, and cross moments, N m, for each N m of drive torque: a mechanism that stands a little off its axis."""
NOISE_N, NOISE_RAD_S = 5e-3, 0.05
"""Noise of forces, at the paper's gear ratio, and of the tachometer."""
RANGES = tuple(m * 10.0**e for e in range(-2, 4) for m in (1.0, 2.0, 5.0))
HEADROOM, CLIPPED_AT = 1.3, 0.8
"""A range is the first that holds so many times the largest sample; the clipped record's is a share of its peak."""
BITS = 16


@dataclass(frozen=True)
class Sizes:
    """Noise of a table: that of the paper's bench, in proportion to the gear ratio.

    A transducer for larger torques has more of it.
    """

    ratio: float

    @property
    def noise_Nm(self) -> float:
        """Of each sample."""
        return NOISE_NM * self.ratio

    @property
    def noise_N(self) -> float:
        """Of each sample of a force."""
        return NOISE_N * self.ratio


def measured(
    torque: np.ndarray, rate: np.ndarray, time: np.ndarray, ratio: float, rng: np.random.Generator
) -> np.ndarray:
    """Return what the table measures about its reference point, and the tachometer, (N, 7) as `COLUMNS`.

    Parameters
    ----------
    torque, rate : (N,)
        What the mechanism exerts about its axis, N m, and the rotor's rate, rad/s.
    time : (N,) s
    ratio : float
        Of the gear, over the paper's.
    rng : Generator
    """
    size, n = Sizes(ratio), time.size
    force = np.column_stack([FORCE_PER_NM[axis] * torque for axis in "xyz"])
    moment = np.column_stack([CROSS["x"] * torque, CROSS["y"] * torque, torque]) + np.cross(POINT_M, force)
    phase = 2.0 * math.pi * rng.uniform()
    moment[:, 2] += HUM * size.noise_Nm * _hum(time, phase)
    offset, drift = rng.normal(0.0, (OFFSET_NM * ratio, DRIFT_NM * ratio))
    moment[:, 2] += offset + drift * np.linspace(0.0, 1.0, n)
    noise = np.repeat([size.noise_N, size.noise_Nm], 3) * rng.standard_normal((n, 6))
    return np.column_stack([force + noise[:, :3], moment + noise[:, 3:], rate + NOISE_RAD_S * rng.standard_normal(n)])


def _hum(time: np.ndarray, phase: float) -> np.ndarray:
    turns = 2.0 * math.pi * MAINS_HZ * time + phase
    return np.sin(turns) + np.sin(3.0 * turns) / 3.0


def recorded(table: np.ndarray, *, clipped: bool) -> tuple[np.ndarray, Mapping[str, float]]:
    """Return all columns in steps of their converters, and the range of each.

    Beyond its range a converter stays at its end; the torque of a clipped record goes there.
    """
    ranges = {name: _range(float(np.max(np.abs(column)))) for name, column in zip(COLUMNS, table.T, strict=True)}
    if clipped:
        ranges["Mz"] = float(f"{CLIPPED_AT * np.max(np.abs(table[:, COLUMNS.index('Mz')])):.2g}")
    ends = np.array([ranges[name] for name in COLUMNS])
    steps = 2.0 * ends / 2**BITS
    return np.clip(steps * np.round(table / steps), -ends, ends), ranges


def _range(largest: float) -> float:
    return next(one for one in RANGES if one >= HEADROOM * largest)
