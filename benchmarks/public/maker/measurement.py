"""Measurement of a run: offset, drift, noise of a kind, mains hum, and a transducer that works loose."""

import math
from collections.abc import Callable, Mapping

import numpy as np
from scipy.signal import lfilter

from ..mechid_benchmark.emission import RATE_HZ

NOISE_NM, OFFSET_NM, DRIFT_NM = 2e-3, 10e-3, 4e-3
"""Standard deviations: of each sample; between records, of the offset and of the drift over a record."""
MAINS_HZ = 50.02
BITS, RANGE_NM = 16, 10.0
"""Converter of the bench noise: its step is 0.3 mN m."""
LOOSE_FROM, LOOSE_GAIN = (0.3, 0.6), (0.5, 0.7)
"""Instant at which the transducer works loose, as a share of the record, and the gain that it has left."""
WARM_UP = 20_000


def _white(rng: np.random.Generator, samples: int) -> np.ndarray:
    return NOISE_NM * rng.standard_normal(samples)


def _resonant(rng: np.random.Generator, samples: int) -> np.ndarray:
    """Return noise about the transducer's resonance, and half as much white noise."""
    return _coloured(rng, samples, radius=0.9, frequency_hz=888.0) + 0.5 * _white(rng, samples)


def _bench(rng: np.random.Generator, samples: int) -> np.ndarray:
    """Return white noise, a floor that moves at 46 Hz, and mains hum with its third harmonic."""
    turns = 2.0 * np.pi * (MAINS_HZ * np.arange(samples) / RATE_HZ + rng.uniform())
    hum = 0.5 * NOISE_NM * (np.sin(turns) + np.sin(3.0 * turns) / 3.0)
    return _white(rng, samples) + 0.3 * _coloured(rng, samples, radius=0.99, frequency_hz=46.0) + hum


def _coloured(rng: np.random.Generator, samples: int, *, radius: float, frequency_hz: float) -> np.ndarray:
    """Return stationary noise of standard deviation `NOISE_NM` with one pair of poles."""
    a_1, a_2 = -2.0 * radius * math.cos(2.0 * math.pi * frequency_hz / RATE_HZ), radius**2
    series = lfilter([1.0], [1.0, a_1, a_2], rng.standard_normal(samples + WARM_UP))[WARM_UP:]
    variance = (1.0 + a_2) / ((1.0 - a_2) * ((1.0 + a_2) ** 2 - a_1**2))
    return NOISE_NM / math.sqrt(variance) * series


NOISES: Mapping[str, Callable[[np.random.Generator, int], np.ndarray]] = {
    "white": _white,
    "resonant": _resonant,
    "bench": _bench,
}


def measured(
    torque: np.ndarray, rng: np.random.Generator, *, noise: str, mains_Nm: float = 0.0, loose: bool = False
) -> np.ndarray:
    """Return a record, (N,) N m, of the torque that the mechanism exerts, (N,) N m.

    Parameters
    ----------
    torque : (N,)
    rng : Generator
    noise : str
        Key of `NOISES`; the records of "bench" are rounded to the steps of a converter, too.
    mains_Nm : float
        Amplitude of the mains hum; a third of it at three times the frequency.
    loose : bool
        Whether the transducer works loose within the record.
    """
    samples = torque.size
    offset, drift = rng.normal(0.0, (OFFSET_NM, DRIFT_NM))
    turns = 2.0 * np.pi * (MAINS_HZ * np.arange(samples) / RATE_HZ + rng.uniform())
    if loose:
        first = round(rng.uniform(*LOOSE_FROM) * samples)
        torque = np.concatenate([torque[:first], rng.uniform(*LOOSE_GAIN) * torque[first:]])
    y = torque + mains_Nm * (np.sin(turns) + np.sin(3.0 * turns) / 3.0)
    y = y + offset + drift * np.linspace(0.0, 1.0, samples) + NOISES[noise](rng, samples)
    step = 2.0 * RANGE_NM / 2**BITS
    return step * np.round(y / step) if noise == "bench" else y
