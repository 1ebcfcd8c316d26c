"""Pointing error indices: the weights on a spectrum against the standard's definitions, worked out in time."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy import signal

from mechid.budgets.indices import KINDS, Index
from mechid.budgets.pointing_error import Random
from mechid.errors import InputFileError
from mechid.signal.power import cumulative_rms, power_density, windowed_rms

RATE_HZ = 200.0
WINDOW, SEPARATION = 60, 250
"""Samples."""
INDICES = [
    Index("APE"),
    Index("MPE", WINDOW / RATE_HZ),
    Index("RPE", WINDOW / RATE_HZ),
    Index("PDE", WINDOW / RATE_HZ, SEPARATION / RATE_HZ),
    Index("PRE", WINDOW / RATE_HZ, 4 * SEPARATION / RATE_HZ),
]


def by_definition(index, e, rate_hz=RATE_HZ):
    """Return the mean square of the index over all windows (and instants) of a periodic record, straight from 3.2."""
    n = round(index.window_s * rate_hz)
    if index.kind == "APE":
        return np.mean(e**2)
    windows = np.lib.stride_tricks.sliding_window_view(np.concatenate([e, e[: n - 1]]), n)
    mean = windows.mean(axis=1)
    if index.kind == "MPE":
        return np.mean(mean**2)
    if index.kind == "RPE":
        return np.mean((windows - mean[:, None]) ** 2)
    return np.mean((np.roll(mean, -round(index.separation_s * rate_hz)) - mean) ** 2)


def coloured(seed, n=20_000):
    """Return noise of the low frequencies that the windows tell apart, its mean removed."""
    b, a = signal.butter(2, 4.0, fs=RATE_HZ)
    e = signal.lfilter(b, a, np.random.default_rng(seed).normal(size=n + 2000))[2000:]
    return e - e.mean()


@pytest.mark.parametrize("index", INDICES, ids=lambda index: index.kind)
def test_the_weights_are_the_definitions(index):
    """Truth: the definitions of ECSS-E-ST-60-10C, 3.2, on a record; 1e-3 is the window's sum instead of an integral."""
    e = coloured(1)
    f, density = power_density(e, RATE_HZ)
    variance = Random(f, density[:, None]).variance(index)
    np.testing.assert_allclose(variance, by_definition(index, e), rtol=1e-3)


@pytest.mark.parametrize("index", INDICES, ids=lambda index: index.kind)
@pytest.mark.parametrize("frequency_hz", [0.2, 1.3, 7.9])
def test_a_line_keeps_what_its_gains_say(index, frequency_hz):
    """Truth: the definitions on a sine; the gains' mean square is the weight."""
    rate_hz = 1000.0  # the window's sum is its integral to 1e-3
    e = np.cos(2.0 * np.pi * frequency_hz * np.arange(20_000) / rate_hz + 0.3)
    gains = index.gains(np.array([frequency_hz]), (np.arange(2000) + 0.5) / 2000 - 0.5)
    square = 0.5 * float(np.mean(np.abs(gains[:, 0]) ** 2))
    np.testing.assert_allclose(square, 0.5 * index.weight(np.array([frequency_hz]))[0], rtol=1e-5, atol=1e-15)
    np.testing.assert_allclose(square, by_definition(index, e, rate_hz), rtol=3e-3, atol=1e-6)


def whole(name, window_s=0.3, separation_s=1.25):
    """Return the index of a row, with the times that it needs."""
    row = KINDS[name]
    return Index(name, window_s if row.has_window else 0.0, separation_s if row.separations else 0.0)


ROWS = pytest.mark.parametrize("name", list(KINDS))


@ROWS
def test_a_rows_weight_is_the_mean_square_of_its_gain_over_the_window(name):
    """Truth: the integral of |gain|^2 over the window, by Gauss's rule of 60 points."""
    index, f = whole(name), np.geomspace(0.01, 30.0, 200)
    places, weights = np.polynomial.legendre.leggauss(60)
    square = 0.5 * weights @ np.abs(index.gains(f, 0.5 * places)) ** 2
    np.testing.assert_allclose(index.weight(f), square, rtol=1e-9, atol=1e-12)


@ROWS
def test_a_rows_weight_is_the_variance_of_its_form_on_noise(name):
    """Truth: the mean square of the index over 200 000 windows of a periodic record, with an instant in each."""
    index, e = whole(name), coloured(2)
    f, density = power_density(e, RATE_HZ)
    rng = np.random.default_rng(3)
    start, position = rng.integers(0, e.size, 200_000), rng.uniform(size=200_000)
    longer = np.concatenate([e, e[: index.samples(RATE_HZ)]])[:, None]
    found = np.mean(index.in_time(longer, RATE_HZ, start, position) ** 2)
    np.testing.assert_allclose(Random(f, density[:, None]).variance(index)[0], found, rtol=0.02)


@ROWS
@pytest.mark.parametrize("frequency_hz", [0.15, 0.7, 2.9])
def test_a_rows_form_on_a_sine_is_its_gain(name, frequency_hz):
    """Truth: the sine multiplied by the gain, window by window and instant by instant, not only in the mean."""
    index, rate_hz, turn = whole(name), 10_000.0, 2j * np.pi * frequency_hz
    series = np.exp(turn * np.arange(100_000) / rate_hz).real[:, None]
    rng = np.random.default_rng(4)
    start = rng.integers(0, 100_000 - index.samples(rate_hz), 300)
    position = rng.uniform(size=300)
    gains = index.gains(np.array([frequency_hz]), position - 0.5)[:, 0]
    centre = start / rate_hz + 0.5 * index.window_s
    expected = (gains * np.exp(turn * centre)).real
    np.testing.assert_allclose(index.in_time(series, rate_hz, start, position)[:, 0], expected, atol=2e-3)


@ROWS
def test_what_a_row_keeps_of_a_bias(name):
    """Truth: its form on a constant, at every place of a window; of the standard's five APE and MPE alone keep it."""
    index, series = whole(name), np.full((2000, 1), 3.0)
    start, position = np.zeros(50, dtype=np.int64), np.linspace(0.0, 0.99, 50)
    np.testing.assert_allclose(index.in_time(series, RATE_HZ, start, position), 3.0 * index.bias_gain, atol=1e-12)
    np.testing.assert_allclose(index.gains(np.zeros(1), position - 0.5), index.bias_gain, atol=1e-12)
    assert index.bias_gain == (1.0 if name in ("APE", "MPE") else 0.0)


def test_the_table_of_the_documentation_is_the_rows():
    """Truth: the rows."""
    text = (Path(__file__).parents[2] / "docs" / "budget.md").read_text(encoding="utf-8")
    found = re.findall(r"^[|] (\w+) [|] (.*) [|] (.*) [|]$", text.split("## Pointing error indices")[1], re.MULTILINE)
    shown = [
        (row.name, row.words, "1" if row.weight_words == "1" else f"${row.weight_words}$") for row in KINDS.values()
    ]
    assert found[1 : 1 + len(shown)] == shown


def test_a_slow_drift_under_rpe_is_largest_at_the_windows_end():
    """Truth: a slope v over a window T, less its mean, ends at v T/2."""
    f, window = 1e-3, 1.0
    gains = Index("RPE", window).gains(np.array([f]), np.array([0.5]))
    assert np.abs(gains).max() == pytest.approx(2.0 * np.pi * f * window / 2.0, rel=2e-3)


@pytest.mark.parametrize("n", [1000, 1001])
def test_parseval(n):
    """Truth: the sum of the density times the step is the mean square, to rounding."""
    y = np.random.default_rng(2).normal(1.0, 2.0, n)
    f, density = power_density(y, RATE_HZ)
    assert density.sum() * f[1] == pytest.approx(np.mean(y**2), rel=1e-12)
    assert cumulative_rms(f, density)[-1] == pytest.approx(y.std(), rel=1e-12)


def test_cumulative_rms_steps_by_each_line():
    """Truth: A/sqrt(2) of the first line, then the root of the squares."""
    t = np.arange(1000) / RATE_HZ
    y = 3.0 * np.cos(2.0 * np.pi * 10.0 * t) + 4.0 * np.sin(2.0 * np.pi * 50.0 * t)
    f, density = power_density(y, RATE_HZ)
    rms = cumulative_rms(f, density)
    at = [f.searchsorted(x) for x in (5.0, 30.0, 90.0)]
    np.testing.assert_allclose(rms[at], np.sqrt([0.0, 4.5, 12.5]), atol=1e-6)


def test_windowed_rms_of_a_sweep():
    """Truth: each window's own standard deviation."""
    y = np.random.default_rng(3).normal(5.0, 1.0, 300) * np.linspace(1.0, 3.0, 300)
    expected = [y[k : k + 40].std() for k in range(261)]
    np.testing.assert_allclose(windowed_rms(y, RATE_HZ, 40 / RATE_HZ), expected, rtol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("RPEE",), 'did you mean "RPE"'),
        (("RPE",), "RPE needs window_s"),
        (("APE", 1.0), "APE has no window"),
        (("PDE", 1.0), "PDE needs separation_s"),
        (("MPE", 1.0, 2.0), "MPE has no separation"),
    ],
)
def test_an_index_that_cannot_be(arguments, said):
    with pytest.raises(InputFileError, match=said):
        Index(*arguments)
