"""A synthetic six-component bench: exported loads, background, mains. It shares nothing with mechid's kernel.

Background levels are as published for a real bench over 0 to 500 Hz, coloured: white and a part that falls with the
frequency.
"""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

COLUMNS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
DIRECTIONS = ("fx", "fy", "fz", "mx", "my", "mz")
BACKGROUND_RMS = np.array([0.029, 0.029, 0.037, 3.8e-3, 3.2e-3, 1.2e-3])
"""N and N m, over 0 to 500 Hz."""
CROSS_TALK = 0.03
MODES_HZ = np.array([30.0, 70.0, 140.0, 260.0, 450.0])


@dataclass
class Run:
    rate: float
    load: np.ndarray
    """Exported at the interface, (6, N), without noise."""
    measured: np.ndarray
    lines: list
    """For each direction the frequencies and peak amplitudes of its sines."""


@dataclass
class Bench:
    sample_rate_hz: float
    runs: list
    background: np.ndarray


def make_bench(seed, *, sample_rate_hz=4000.0, seconds=12.0, cross_talk=0.0, broadband=True):
    """Return a bench with 4 to 12 rates."""
    rng = np.random.default_rng(seed)
    rates = np.sort(rng.uniform(8.0, 120.0, rng.integers(4, 13)))
    samples = round(seconds * sample_rate_hz)
    gains = 10.0 ** rng.uniform(-1.0, 1.0, (6, 1)) * BACKGROUND_RMS[:, None]
    shape = rng.uniform(0.2, 1.0, (6, MODES_HZ.size)) * rng.uniform(0.9, 1.1, MODES_HZ.size)
    frequency = MODES_HZ * rng.uniform(0.9, 1.1, MODES_HZ.size)
    zeta = rng.uniform(0.005, 0.03, MODES_HZ.size)
    mains = rng.uniform(0.1, 0.6, (6, 4)) * BACKGROUND_RMS[:, None] / np.arange(1, 5)
    mains_hz = 50.0 * (1.0 + rng.normal(0.0, 2e-4))
    runs = []
    for rate in rates:
        load, lines = _load(rng, rate, (gains, shape, frequency, zeta), samples, sample_rate_hz)
        if broadband:
            load = load + 0.1 * gains * _coloured(rng, samples, sample_rate_hz)
        table = load + cross_talk * (np.sum(load, axis=0, keepdims=True) - load)
        runs.append(Run(rate, load, table + _background(rng, samples, sample_rate_hz, mains, mains_hz), lines))
    return Bench(sample_rate_hz, runs, _background(rng, samples, sample_rate_hz, mains, mains_hz))


def _load(rng, rate, how, samples, sample_rate_hz):
    """Return sines at the orders of the step rate through the mechanism's modes, (6, N), and what they are."""
    gains, shape, frequency, zeta = how
    time = np.arange(samples) / sample_rate_hz
    orders = np.concatenate([[0.5], np.arange(1.0, 13.0)])
    orders = orders[orders * rate < 0.35 * sample_rate_hz]
    f = orders * rate
    response = 1.0 / (1.0 - (f[:, None] / frequency) ** 2 + 2j * zeta * f[:, None] / frequency)
    excitation = orders**-0.7 * 10.0 ** rng.normal(0.0, 0.2, orders.size)
    amplitude = gains * excitation * np.abs(0.2 + shape @ response.T * 0.2)
    phase = rng.uniform(0.0, 2.0 * np.pi, amplitude.shape)
    load = np.zeros((6, samples))
    for k, each in enumerate(f):
        load += amplitude[:, k : k + 1] * np.cos(2.0 * np.pi * each * time + phase[:, k : k + 1])
    return load, [(f, row) for row in amplitude]


def _coloured(rng, samples, sample_rate_hz):
    """Return noise of RMS 1 over 0 to 500 Hz: a white part and one that falls above 40 Hz, (6, N)."""
    white = rng.normal(size=(6, samples)) * np.sqrt(0.5 * sample_rate_hz / 500.0)
    pole = np.exp(-2.0 * np.pi * 40.0 / sample_rate_hz)
    red = lfilter([1.0 - pole], [1.0, -pole], white, axis=1)
    # over 0 to 500 Hz a first-order low-pass of 40 Hz keeps 40 / 500 arctan(500 / 40) of white noise's power
    return np.sqrt(0.5) * white + np.sqrt(0.5 / (0.08 * np.arctan(12.5))) * red


def _background(rng, samples, sample_rate_hz, mains, mains_hz):
    time = np.arange(samples) / sample_rate_hz
    noise = BACKGROUND_RMS[:, None] * _coloured(rng, samples, sample_rate_hz)
    for k in range(mains.shape[1]):
        wander = 1.0 + 0.05 * rng.normal()
        phase = rng.uniform(0.0, 2.0 * np.pi, (6, 1))
        noise += wander * mains[:, k : k + 1] * np.sin(2.0 * np.pi * (k + 1) * mains_hz * time + phase)
    return noise


def write_bench(bench, folder):
    """Write the records as .npy arrays and campaign.toml; return its path."""
    folder.mkdir(parents=True, exist_ok=True)
    quantities = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "torque")
    channels = ", ".join(
        f'{{ quantity = "{q}", column = {k}, unit = "{"N" if q.startswith("f") else "N*m"}" }}'
        for k, q in enumerate(quantities)
    )
    shared = f"sample_rate_hz = {bench.sample_rate_hz}\nchannels = [{channels}]\n"
    text = 'mechanism = "mechanism.toml"\nsynthetic = true\n\n'
    text += '[bench]\ndrive_axis = "z"\nmounting_point_m = [0.0, 0.0, 0.0]\n'
    for k, run in enumerate(bench.runs):
        np.save(folder / f"run_{k}.npy", run.measured.T)
        text += f'\n[[record]]\nname = "run_{k}"\nfile = "run_{k}.npy"\n{shared}'
        text += f'command = {{ stepping = "micro", microsteps = 16, rate = {float(run.rate)!r} }}\n'
    np.save(folder / "off.npy", bench.background.T)
    text += f'\n[[background]]\nname = "off"\nfile = "off.npy"\nstate = "off"\n{shared}'
    (folder / "campaign.toml").write_text(text)
    return folder / "campaign.toml"
