"""Truth: the arrays that were packed, and the bound that a page promises."""

import numpy as np
import pytest

from mechid.analysis.prediction import Prediction
from mechid.report.packing import pack_floats, pack_integers, unpack
from mechid.report.trace import decode, trace_of
from mechid.signal.trend import Line
from mechid.simulation.simulator import TimeBase

RNG = np.random.default_rng(4)
NOISE = 0.002


def prediction(n, *, noise=NOISE, failed_from=None):
    t = np.arange(n) / 1e4
    modelled = (0.02 + 0.3 * np.exp(-(((t - 46.0) / 3.0) ** 2))) * np.sin(2.0 * np.pi * t * t)
    removed = Line(0.01, -0.004 / 1e4)
    measured = modelled + removed.at(0, n) + noise * RNG.standard_normal(n)
    if failed_from is not None:
        modelled = np.where(np.arange(n) < failed_from, modelled, np.nan)
        removed = Line(np.nan, np.nan)
    return Prediction(
        measured=measured, removed=removed, modelled=modelled, travel=np.zeros(n), base=TimeBase(1e4, n, 0.5)
    )


@pytest.mark.parametrize("n", [1, 2, 3, 1000, 600_001])
def test_every_sample_comes_back_within_a_twentieth_of_the_noise(n):
    p = prediction(n)
    trace = trace_of(p, NOISE)
    measured, modelled = decode(trace)
    back = measured + trace.offset + trace.drift * np.arange(n)
    assert trace.step <= 0.1 * NOISE
    assert np.abs(back - p.measured).max() <= 0.0501 * NOISE
    assert np.abs(modelled - p.modelled).max() <= 0.0501 * NOISE


def test_a_sweep_of_600_001_samples_takes_less_than_a_megabyte():
    trace = trace_of(prediction(600_001), NOISE)
    assert len(trace.model["data"]) + len(trace.difference["data"]) < 1_000_000


def test_where_the_simulation_fails_the_record_stays():
    p = prediction(500, failed_from=200)
    trace = trace_of(p, NOISE)
    measured, modelled = decode(trace)
    assert np.abs(measured - p.measured).max() <= 0.0501 * NOISE
    assert np.all(np.isnan(modelled[200:]))
    assert np.abs(modelled[:200] - p.modelled[:200]).max() <= 0.0501 * NOISE


@pytest.mark.parametrize("noise", [0.0, np.nan, 1e-15])
def test_without_noise_it_is_as_fine_as_its_numbers_allow(noise):
    p = prediction(1000, noise=0.0)
    measured, _ = decode(trace_of(p, noise))
    assert np.abs(measured + p.removed.at(0, 1000) - p.measured).max() < 1e-8 * np.abs(p.measured).max()


def test_integers_of_31_bits_and_floats_come_back():
    whole = np.array([0, -1, 1, 2**30, -(2**30), 2**31 - 1, -(2**31)])
    assert unpack(pack_integers(whole)).tolist() == whole.tolist()
    floats = RNG.normal(size=100).astype(np.float32).astype(float)
    assert unpack(pack_floats(floats)).tolist() == floats.tolist()
    assert unpack(pack_integers(np.array([], dtype=np.int64))).size == 0
