"""The rate that a record suggests. Truth: signals made at a rate, and campaigns of the independent simulator."""

import numpy as np
import pytest

from mechid.campaign.campaign_file import load_records
from mechid.records.step_rate import read_declared_rate, suggest_rate
from mechid.signal.lines import prominence, spectral_lines

RATE_HZ = 10_000.0
TIME = np.arange(20_000) / RATE_HZ


def suggested(y, rate_hz=RATE_HZ):
    y = y - y.mean()
    found = prominence(y, rate_hz)
    return suggest_rate(y, found, spectral_lines(found))


def noise(seed, sigma=0.01, size=TIME.size):
    return sigma * np.random.default_rng(seed).standard_normal(size)


def blows(rate, repeats=1):
    """Return short blows at a rate, every so manieth of another height."""
    number = np.floor(rate * TIME)
    since = TIME - number / rate
    height = np.where(number % repeats == 0, 1.1, 1.0)
    return height * np.exp(-since / 2e-3) * np.sin(2.0 * np.pi * 400.0 * since)


@pytest.mark.parametrize("repeats", [1, 2])
def test_blows_are_full_steps_at_their_rate(repeats):
    found = suggested(blows(37.3, repeats) + noise(1))
    assert found.profile.rates[0] == pytest.approx(37.3, abs=4.0 * found.sigma)
    assert found.stepping == "full"
    assert found.repetition_hz == pytest.approx(37.3 / repeats, rel=1e-3)


def test_microsteps_are_told_by_their_own_line():
    orders = ((0.5, 0.3), (1.0, 1.0), (2.0, 0.2), (4.0, 0.1), (16.0, 0.1))
    y = sum(a * np.sin(2.0 * np.pi * o * 23.7 * TIME + o) for o, a in orders)
    found = suggested(y + noise(2))
    assert found.profile.rates[0] == pytest.approx(23.7, abs=4.0 * found.sigma)
    assert (found.stepping, found.microsteps) == ("micro", 16)


def test_a_sweep_is_found_with_both_ends():
    time = np.arange(20_000) / 2000.0
    phase = 2.0 * np.pi * (20.0 * time + 0.5 * 8.0 * time**2)
    found = suggested(np.sin(phase) + 0.3 * np.sin(2.0 * phase) + noise(3, 0.3), 2000.0)
    assert found.profile.rates == pytest.approx((20.0, 100.0), abs=1.0)
    assert not found.is_constant


@pytest.mark.parametrize("seed", range(8))
def test_noise_and_lines_without_a_fundamental_suggest_nothing(seed):
    """Three lines at random are multiples of something only by chance, which is too likely to be said."""
    frequencies = np.random.default_rng(seed).uniform(20.0, 400.0, 3)
    assert suggested(noise(seed)) is None
    assert suggested(noise(seed) + sum(np.sin(2.0 * np.pi * f * TIME) for f in frequencies)) is None


def test_a_declared_rate_is_read_at_its_own_part_of_the_repetition():
    found = suggested(blows(37.3, 2) + noise(4))
    reading = read_declared_rate(found, 37.0)
    assert reading.repeats == 2.0
    assert reading.rate == pytest.approx(37.3, abs=4.0 * reading.sigma)
    assert read_declared_rate(found, 41.0) is None


def test_records_of_the_independent_simulator(campaign_folder):
    """Truth: their commands. Of microsteps at twice the resonance the largest line is once every two full steps."""
    records = {record.name: record for record in load_records(campaign_folder / "noisy")}
    rates = {"full_res": 59.4, "full_half": 29.7, "full_slow": 5.0, "micro_res": 59.4, "micro_2res": 118.8}
    for name, rate in rates.items():
        data = records[name].data
        found = suggested(data.channel("torque").data, data.sample_rate_hz)
        reading = read_declared_rate(found, rate)
        assert reading.rate == pytest.approx(rate, abs=4.0 * reading.sigma), name
        assert reading.sigma < 1e-3 * rate
        assert rate == pytest.approx(found.rate, rel=1e-3) or any(
            rate == pytest.approx(r, rel=1e-3) for r in found.others
        )
        expected = {"full": "full", "micr": "micro"}[name[:4]] if name != "micro_2res" else ""
        assert found.stepping == expected
    sweep = records["sweep"].data
    assert suggested(sweep.channel("torque").data).profile.rates == pytest.approx((0.0, 142.56), abs=0.5)
