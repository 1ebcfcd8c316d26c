"""Predicted quantities of a torque with known lines. Truth: scipy.signal on its samples, and closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal
from scipy.stats import f as f_distribution

from mechid.budgets.predicted_values import (
    TorqueAtRate,
    _unmodelled_quantile,
    _with_fewer_draws,
    band_gain,
    predict_values,
)
from mechid.budgets.residual_source import EDGES_HZ
from mechid.budgets.torque_draws import TorqueDraws
from mechid.specification.requirement import Mask, Requirement

RATE, FS, SECONDS = 40.0, 4000.0, 40.0
ORDERS = np.array([0.5, 1.0, 2.0, 3.5])
LINES = np.array([0.02, 0.1j, -0.05, 0.03 * np.exp(0.7j)])
BAND = (1.0, 500.0)


def torque(*, spread=0.0, limit=(0.0, 0.0, 0.0, 0.0), residual=(0.0, 0.0, 0.0, 0.0), density=0.0, draws=400):
    """Return the draws of four lines: each off by a common normal share, and by circular normal torque."""
    rng = np.random.default_rng(5)
    own = LINES * (1.0 + spread * rng.normal(size=(draws, 1)))
    both = rng.normal(size=(2, draws, 4)) / np.sqrt(2.0)
    return TorqueAtRate(
        draws=TorqueDraws(
            orders=ORDERS,
            frequency_hz=RATE * ORDERS,
            modelled=LINES,
            residual=np.array(residual),
            limit=np.array(limit),
            error=np.zeros(4),
            samples=own + (both[0] + 1j * both[1]) * np.array(limit),
            scale=np.ones((draws, 1)),
            density=np.full(EDGES_HZ.size - 1, density),
        ),
        rate=RATE,
        steps=2,
        rates=50,
        random=np.zeros((0, 2)),
        alpha=0.025,
        looks=1,
    )


def wanted(kind, points=((5.0, 1.0), (60.0, 1.0), (400.0, 1.0)), resolution=1.0):
    frequency, limits = np.array(points).T
    mask = Mask(frequency, limits, kind in ("rms", "band_peak"))
    return Requirement(name=kind, direction="torque", kind=kind, mask=mask, resolution_hz=resolution)


def samples():
    time = np.arange(round(FS * SECONDS)) / FS
    return np.real(np.exp(2j * np.pi * np.outer(time, RATE * ORDERS)) @ LINES)


def test_lines_are_judged_at_their_amplitude():
    found = predict_values(torque(), wanted("amplitude"), BAND)
    at = np.isin(found.frequency_hz, RATE * ORDERS)
    assert found.value[at] == pytest.approx(np.abs(LINES))
    assert found.upper[at] == pytest.approx(np.abs(LINES))
    assert found.lower[at] == pytest.approx(np.abs(LINES))
    assert not found.upper[~at].any()


@pytest.mark.parametrize("resolution", [1.0, 0.8])
def test_densities_are_those_of_welch(resolution):
    """Truth: scipy.signal.welch over 40 s; lines on bins and beside them."""
    length = round(FS / resolution)
    frequency, density = signal.welch(samples(), FS, "hann", length, length // 2, detrend="constant")
    found = predict_values(torque(), wanted("psd", resolution=resolution), BAND)
    truth = np.interp(found.frequency_hz, frequency, density)
    loud = truth > 1e-3 * truth.max()
    assert found.value[loud] == pytest.approx(truth[loud], rel=0.01)


def test_bands_hold_the_power_of_their_lines():
    found = predict_values(torque(), wanted("rms"), BAND)
    powers = [0.5 * np.sum(np.abs(LINES[:2]) ** 2), 0.5 * np.sum(np.abs(LINES[2:]) ** 2)]
    assert found.value == pytest.approx(np.sqrt(powers), rel=1e-3)


def test_a_density_fills_third_octaves():
    """Truth: density times bandwidth, in the third octave about 200 Hz, which has no line."""
    found = predict_values(torque(density=1e-6), wanted("third_octave"), BAND)
    k = int(np.argmin(np.abs(found.frequency_hz - 199.5)))
    width = 10.0**2.3 * (10.0**0.05 - 10.0**-0.05)
    assert found.value[k] == pytest.approx(np.sqrt(1e-6 * width), rel=1e-3)


def test_band_peaks_are_those_of_filtered_samples():
    """Truth: scipy.signal.sosfilt of the samples, without its first second."""
    found = predict_values(torque(), wanted("band_peak"), BAND)
    for (low, high), value, upper in zip(((5.0, 60.0), (60.0, 400.0)), found.value, found.upper, strict=True):
        sections = signal.butter(4, (low, high), "bandpass", fs=FS, output="sos")
        truth = np.abs(signal.sosfilt(sections, samples()))[round(FS) :].max()
        assert value == pytest.approx(truth, rel=0.01)
        assert truth <= upper <= 1.04 * truth


def test_long_waveforms_take_fewer_draws():
    """Truth: the same lines of a motion that repeats after 400 steps, whose peak is the same."""
    quick, long = torque(spread=0.05), replace(torque(spread=0.05), steps=400)
    assert len(_with_fewer_draws(quick, 400.0).draws.samples) == 400
    assert len(_with_fewer_draws(long, 400.0).draws.samples) == 100
    found, other = (predict_values(at, wanted("band_peak"), BAND) for at in (quick, long))
    assert other.value == pytest.approx(found.value, rel=1e-3)
    assert other.upper == pytest.approx(found.upper, rel=0.03)


def test_the_band_pass_is_the_digital_one_of_high_sample_rates():
    frequency = np.array([30.0, 60.0, 150.0, 400.0, 900.0])
    sections = signal.butter(4, (60.0, 400.0), "bandpass", fs=100_000.0, output="sos")
    truth = signal.sosfreqz(sections, frequency, fs=100_000.0)[1]
    assert band_gain(frequency, (60.0, 400.0)) == pytest.approx(truth, abs=2e-3)


@pytest.mark.parametrize("kind", ["amplitude", "psd", "rms", "third_octave", "band_peak"])
def test_bounds_widen_with_the_errors(kind):
    """Truth: a spread of 5 % moves a bound of 97.5 % by 1.96 of it, of powers twice as far."""
    found = predict_values(torque(spread=0.05, draws=4000), wanted(kind), BAND)
    k = int(np.argmax(found.value))
    power = 2.0 if kind == "psd" else 1.0
    above = 1.04 if kind == "band_peak" else 1.0
    assert found.value[k] * 1.09**power < found.upper[k] < found.value[k] * 1.11**power * above
    assert found.lower[k] < found.value[k] * 0.9**power


def test_what_noise_may_hide_counts_as_background():
    """Truth: the limits; a line that the records show is no background."""
    at = torque(limit=(0.01, 0.01, 0.0, 0.0), residual=(0.0, 0.01, 0.0, 0.0))
    found = predict_values(at, wanted("amplitude"), BAND)
    hidden = dict(zip(found.frequency_hz.tolist(), found.background.tolist(), strict=True))
    assert [hidden[f] for f in (20.0, 40.0, 80.0)] == [0.01, 0.0, 0.0]
    upper = dict(zip(found.frequency_hz.tolist(), found.upper.tolist(), strict=True))
    assert upper[20.0] > 0.02
    assert found.lower[found.frequency_hz == 20.0] == 0.0


@pytest.mark.parametrize("rates", [1, 4, 50])
def test_the_unmodelled_quantile_is_that_of_fisher(rates):
    """Truth: scipy.stats, |E|^2 / A^2 with F(2, 2 n)."""
    assert _unmodelled_quantile(rates, 1e-3) ** 2 == pytest.approx(f_distribution.isf(1e-3, 2, 2 * rates), rel=1e-9)


def test_what_does_not_repeat_adds_its_density():
    at = torque()
    random = np.column_stack([np.arange(0.0, 1000.0, 0.25), np.full(4000, 1e-5)])
    object.__setattr__(at, "random", random)
    found = predict_values(at, wanted("psd"), BAND)
    assert found.value[found.frequency_hz == 150.0] == pytest.approx(1e-5)
