"""A synthetic six-component bench: exported loads, table, background, mains. It shares nothing with mechid's kernel.

Background levels are as published for a real bench over 0 to 500 Hz, coloured: white and a part that falls with the
frequency. The table has a mode for each component at 900 to 1400 Hz, and its channels 3 % of cross-talk.
"""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from .table import Table, make_table

COLUMNS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
DIRECTIONS = ("fx", "fy", "fz", "mx", "my", "mz")
BACKGROUND_RMS = np.array([0.029, 0.029, 0.037, 3.8e-3, 3.2e-3, 1.2e-3])
"""N and N m, over 0 to 500 Hz."""
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
    table: Table | None = None


def make_bench(seed, *, sample_rate_hz=4000.0, seconds=12.0, broadband=True, table=False, noise=1.0):
    """Return a bench with 4 to 12 rates, with or without a table; `noise` scales the background."""
    rng = np.random.default_rng(seed)
    rates = np.sort(rng.uniform(8.0, 120.0, rng.integers(4, 13)))
    samples = round(seconds * sample_rate_hz)
    gains = 10.0 ** rng.uniform(-1.0, 1.0, (6, 1)) * BACKGROUND_RMS[:, None]
    shape = rng.uniform(0.2, 1.0, (6, MODES_HZ.size)) * rng.uniform(0.9, 1.1, MODES_HZ.size)
    frequency = MODES_HZ * rng.uniform(0.9, 1.1, MODES_HZ.size)
    zeta = rng.uniform(0.005, 0.03, MODES_HZ.size)
    mains = rng.uniform(0.1, 0.6, (6, 4)) * BACKGROUND_RMS[:, None] / np.arange(1, 5)
    mains_hz = 50.0 * (1.0 + rng.normal(0.0, 2e-4))
    # drawn from a seed of its own, so that a bench has the same loads with and without a table
    own = make_table(np.random.default_rng(seed + 20_000), BACKGROUND_RMS) if table else None
    runs = []
    for rate in rates:
        load, lines, at = _load(rng, rate, (gains, shape, frequency, zeta), samples, sample_rate_hz, own)
        if broadband:
            random = 0.1 * gains * _coloured(rng, samples, sample_rate_hz)
            load = load + random
            at = at + (own.periodic(random, sample_rate_hz) if own else random)
        measured = own.cross_talk @ at if own else at
        behind = noise * _background(rng, samples, sample_rate_hz, mains, mains_hz)
        runs.append(Run(rate, load, measured + behind, lines))
    return Bench(sample_rate_hz, runs, noise * _background(rng, samples, sample_rate_hz, mains, mains_hz), own)


def _load(rng, rate, how, samples, sample_rate_hz, table):
    """Return sines at the orders of the step rate through the mechanism's modes, (6, N), what they are, and (6, N) as
    the table's modes pass them on."""
    gains, shape, frequency, zeta = how
    time = np.arange(samples) / sample_rate_hz
    orders = np.concatenate([[0.5], np.arange(1.0, 13.0)])
    orders = orders[orders * rate < 0.35 * sample_rate_hz]
    f = orders * rate
    response = 1.0 / (1.0 - (f[:, None] / frequency) ** 2 + 2j * zeta * f[:, None] / frequency)
    excitation = orders**-0.7 * 10.0 ** rng.normal(0.0, 0.2, orders.size)
    amplitude = gains * excitation * np.abs(0.2 + shape @ response.T * 0.2)
    phase = rng.uniform(0.0, 2.0 * np.pi, amplitude.shape)
    load, passed = np.zeros((6, samples)), np.zeros((6, samples))
    for k, each in enumerate(f):
        cosine, sine = np.cos(2.0 * np.pi * each * time), np.sin(2.0 * np.pi * each * time)
        turned = amplitude[:, k : k + 1] * np.exp(1j * phase[:, k : k + 1])
        seen = turned * table.response(np.array([each])) if table else turned
        load += turned.real * cosine - turned.imag * sine
        passed += seen.real * cosine - seen.imag * sine
    return load, [(f, row) for row in amplitude], passed


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


def write_bench(bench, folder, *, declared="", unit=None, to_channels=None):
    """Write the records as .npy arrays and campaign.toml; return its path.

    `declared` is what stands below ``[bench]``; `unit` of all channels, and the matrix that makes them of loads.
    """
    folder.mkdir(parents=True, exist_ok=True)
    quantities = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "torque")
    channels = ", ".join(
        f'{{ quantity = "{q}", column = {k}, unit = "{unit or ("N" if q.startswith("f") else "N*m")}" }}'
        for k, q in enumerate(quantities)
    )
    made = np.eye(6) if to_channels is None else to_channels
    shared = f"sample_rate_hz = {bench.sample_rate_hz}\nchannels = [{channels}]\n"
    text = 'mechanism = "mechanism.toml"\nsynthetic = true\n\n'
    text += f'[bench]\ndrive_axis = "z"\nmounting_point_m = [0.0, 0.0, 0.0]\n{declared}'
    for k, run in enumerate(bench.runs):
        np.save(folder / f"run_{k}.npy", (made @ run.measured).T)
        text += f'\n[[record]]\nname = "run_{k}"\nfile = "run_{k}.npy"\n{shared}'
        text += f'command = {{ stepping = "micro", microsteps = 16, rate = {float(run.rate)!r} }}\n'
    np.save(folder / "off.npy", (made @ bench.background).T)
    text += f'\n[[background]]\nname = "off"\nfile = "off.npy"\nstate = "off"\n{shared}'
    (folder / "campaign.toml").write_text(text)
    return folder / "campaign.toml"
