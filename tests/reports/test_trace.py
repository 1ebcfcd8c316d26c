"""Truth: the arrays that were packed, and the bound that a page promises."""

import numpy as np
import pytest

from little_memory import little_memory  # noqa: F401
from mechid.analysis.prediction import Prediction
from mechid.reports import outline
from mechid.reports.outline import decode_outline, outline_of
from mechid.reports.packing import pack_floats, pack_integers, unpack
from mechid.reports.trace import decode, trace_of
from mechid.signal.envelope import envelope
from mechid.signal.stored_series import as_writable
from mechid.signal.trend import Line
from mechid.simulation.simulator import TimeBase

RNG = np.random.default_rng(4)
NOISE = 0.002
COLUMNS, DETAIL_S = 40, 0.05


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


@pytest.fixture
def drawn(little_memory, monkeypatch):  # noqa: F811
    """Return a function that outlines a prediction whose samples are in files."""
    monkeypatch.setattr(outline, "COLUMNS", COLUMNS)
    monkeypatch.setattr(outline, "DETAIL_S", DETAIL_S)

    def draw(p, around):
        object.__setattr__(p, "measured", as_writable(p.measured))
        object.__setattr__(p, "modelled", as_writable(p.modelled))
        return outline_of(p, NOISE, around)

    return draw


@pytest.mark.parametrize("failed_from", [None, 3000])
def test_it_has_the_extremes_of_every_column(drawn, failed_from):
    p = prediction(6001, failed_from=failed_from)
    found = drawn(p, {})
    reached = failed_from or 6001
    truth = {
        "measured": p.level[:],
        "modelled": p.modelled[:reached],
        "residual": (p.level[:] - p.modelled[:])[:reached],
    }
    for name, y in truth.items():
        times, values = decode_outline(found, name)
        kept = envelope(y, COLUMNS)
        np.testing.assert_allclose(times, 0.5 + kept / 1e4, rtol=1e-12)
        assert np.abs(values - y[kept]).max() <= 0.0501 * NOISE
    assert found.column_s == pytest.approx(0.6001 / COLUMNS)


@pytest.mark.parametrize(("middle_s", "first_s"), [(0.5, 0.5), (0.8, 0.775), (1.1, 1.0501), (9.0, 1.0501)])
def test_a_stretch_has_every_sample_around_its_middle_within_the_record(drawn, middle_s, first_s):
    p = prediction(6001)
    trace = drawn(p, {"here": middle_s}).stretches["here"]
    first = round((first_s - 0.5) * 1e4)
    assert (trace.samples, trace.start_s) == (500, pytest.approx(first_s))
    measured, modelled = decode(trace)
    back = measured + trace.offset + trace.drift * np.arange(500)
    assert np.abs(back - p.measured[first : first + 500]).max() <= 0.0501 * NOISE
    assert np.abs(modelled - p.modelled[first : first + 500]).max() <= 0.0501 * NOISE
