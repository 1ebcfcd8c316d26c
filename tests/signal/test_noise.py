"""The noise floor against seeded white noise of known sigma, alone and under strong signals."""

import numpy as np
import pytest
from scipy.signal import lfilter

from mechid.errors import RecordError
from mechid.signal import noise_floor

RATE = 10000.0
HOUSING, DAMPING = 5578.0, 0.095  # rad/s, 1: the resonance of Kornienko2013, at 888 Hz


def white(samples, sigma, seed):
    return sigma * np.random.default_rng(seed).normal(size=samples)


def lagged(y, pole):
    """First-order lag with unit gain, sampled; `pole` in rad/s, complex for half of a resonance."""
    keep = np.exp(-pole / RATE)
    return lfilter([1.0 - keep], [1.0, -keep], y)


def stepped(samples, rate, microsteps, housing):
    """Torque of some 0.5 N m, with a 48 Hz mode; its slope jumps at every (micro)step."""
    step = np.floor(np.arange(samples) * rate * microsteps / RATE) / microsteps
    motor = lagged(np.cos(np.pi / 4.0 + np.pi / 2.0 * step), 220.0)  # 9.9 ohm and 45 mH
    mode = lagged(motor, 15.0 + 300.0j).imag
    if housing:
        motor = lagged(motor, DAMPING * HOUSING + 1j * HOUSING).imag
    return mode + 0.3 * motor


@pytest.mark.parametrize(("samples", "draws", "tolerance"), [(1000, 400, 0.01), (10000, 200, 0.005)])
def test_white_noise_is_unbiased_and_scatters_as_stated(samples, draws, tolerance):
    """Closed form: sigma itself, and 1.7 / sqrt(N) of it as the scatter over seeded draws."""
    found = [noise_floor(white(samples, 0.3, seed), RATE) / 0.3 for seed in range(draws)]
    assert np.mean(found) == pytest.approx(1.0, abs=tolerance)
    assert np.std(found) == pytest.approx(1.7 / np.sqrt(samples), rel=0.2)


@pytest.mark.parametrize("housing", [True, False])
@pytest.mark.parametrize("microsteps", [1, 2, 16])
@pytest.mark.parametrize("rate", [5.0, 46.0, 120.0])
def test_a_stepped_mechanism_does_not_hide_its_noise(rate, microsteps, housing):
    """2 mN m under full, half and microsteps."""
    signal = stepped(20000, rate, microsteps, housing)
    found = noise_floor(signal + white(20000, 2e-3, seed=3), RATE)
    assert 0.02 < np.std(signal) < 2.0
    assert found == pytest.approx(2e-3, rel=0.05)


def test_transients_of_a_short_time_are_passed_over():
    """Bursts a thousand times the noise up to the Nyquist frequency, 4 a second, 5 ms each."""
    noise, burst = white(40000, 1e-3, seed=4), white(40000, 1.0, seed=5)
    y = noise + np.where(np.arange(40000) % 2500 < 50, burst, 0.0)
    assert noise_floor(y, RATE) == pytest.approx(1e-3, rel=0.1)


def test_lines_up_to_the_nyquist_frequency_are_passed_over():
    """An impulse train of 500 Hz has a line at every multiple of it, up to 5 kHz, here of 20 sigma."""
    y = white(40000, 1e-3, seed=6)
    y[::20] += 0.2
    assert noise_floor(y, RATE) == pytest.approx(1e-3, rel=0.05)


def test_the_quieter_part_of_the_band_wins():
    """Noise below 0.7 of the Nyquist frequency does not count where it is quieter above."""
    shaped = np.fft.rfft(white(40000, 1.0, seed=7))
    shaped[int(0.7 * shaped.size) :] *= 0.1
    assert noise_floor(np.fft.irfft(shaped), RATE) == pytest.approx(0.1, rel=0.03)


def test_the_band_can_be_given():
    """Below 4 kHz the noise is ten times stronger; from there on only the weaker is seen."""
    shaped = np.fft.rfft(white(40000, 1.0, seed=8))
    shaped[int(0.7 * shaped.size) :] *= 0.1
    assert noise_floor(np.fft.irfft(shaped), RATE, above=3600.0) == pytest.approx(0.1, rel=0.03)


@pytest.mark.parametrize("samples", [16, 100, 511, 513])
def test_offset_and_drift_are_no_noise(samples):
    y = 5.0 + 2.0 * np.linspace(0.0, 1.0, samples) + white(samples, 1e-2, seed=9)
    assert noise_floor(y, RATE) == pytest.approx(1e-2, rel=0.6)


def test_silence_has_no_noise():
    assert noise_floor(np.zeros(1000), RATE) == 0.0


@pytest.mark.parametrize(("samples", "above"), [(15, None), (1000, 4000.0)])
def test_too_little_is_refused(samples, above):
    with pytest.raises(RecordError, match="cannot estimate a noise floor from"):
        noise_floor(np.zeros(samples), RATE, above=above)


RECORDS = ["full_res", "full_half", "full_slow", "micro_res", "micro_2res", "sweep"]


def torque(folder, kind, name):
    return np.loadtxt(folder / kind / f"{name}.csv", delimiter=",", skiprows=1)[:, 1]


@pytest.mark.parametrize("name", RECORDS)
def test_the_noise_of_the_noisy_campaign_is_found(campaign_folder, name):
    """Truth: the independent simulator added 2 mN m of white noise."""
    assert noise_floor(torque(campaign_folder, "noisy", name), RATE) == pytest.approx(2e-3, rel=0.05)


@pytest.mark.parametrize("name", RECORDS)
def test_the_exact_campaign_has_almost_none(campaign_folder, name):
    """Its records carry no noise; what is left is the signal's own spectrum near 5 kHz."""
    assert noise_floor(torque(campaign_folder, "exact", name), RATE) < 5e-5


def struck(samples, every, seed):
    """Torque with an impact every so many samples, at irregular instants, of 10 to 30 mN m; each rings at 960 Hz."""
    rng = np.random.default_rng(seed)
    hits = np.zeros(samples)
    at = np.cumsum(rng.integers(every // 2, 3 * every // 2, size=samples // every))
    hits[at[at < samples]] = rng.choice([-1.0, 1.0], size=np.count_nonzero(at < samples)) * 0.02
    ring = lagged(hits, 900.0 + 6000.0j).imag * 3.0
    return ring + hits


@pytest.mark.parametrize("every", [60, 200])
def test_impacts_that_fill_every_spectrum_leave_the_noise_between_them(every):
    """Truth: the sigma that made the noise; impacts of a gear with backlash fill the band up to its end."""
    found = [noise_floor(white(10001, 2e-3, seed) + struck(10001, every, seed), RATE) for seed in range(10)]
    assert np.mean(found) == pytest.approx(2e-3, rel=0.1)


def test_a_resolution_that_hides_the_noise_now_and_then_is_no_lower_floor():
    """Truth: rounding to steps of 2 sigma leaves an error of that order; standstill within one step is no noise."""
    slow = 1e-3 * np.sin(2.0 * np.pi * np.arange(20000) / 15000.0)
    found = noise_floor(np.round((slow + white(20000, 2e-5, 3)) / 4e-5) * 4e-5, RATE)
    assert found == pytest.approx(np.hypot(2e-5, 4e-5 / np.sqrt(12.0)), rel=0.3)


@pytest.mark.parametrize("share", [0.15, 0.3, 0.45])
def test_a_standstill_within_the_resolution_is_no_floor(share):
    """Truth: the noise of the samples that move; those that stand still show one value alone."""
    y = np.cumsum(np.full(20000, 1e-4)) + white(20000, 1e-3, 4)
    y[: int(share * y.size)] = 0.0
    assert noise_floor(y, RATE) > 2e-4
