"""Truth: sines of known amplitude, one of them beginning in the middle."""

import numpy as np
import pytest

from mechid.signal.spectrogram import spectrogram

RATE = 1000.0


def test_a_sine_reads_its_amplitude_where_and_when_it_is():
    t = np.arange(4000) / RATE
    y = 0.5 * np.sin(2.0 * np.pi * 50.0 * t) + 2.0 * np.sin(2.0 * np.pi * 120.0 * t) * (t >= 2.0)
    time, frequency, amplitude = spectrogram(y, RATE, 0.5, 40)
    at = {hz: int(np.argmin(np.abs(frequency - hz))) for hz in (50.0, 120.0)}
    early, late = (int(np.argmin(np.abs(time - s))) for s in (1.0, 3.0))
    assert frequency[at[50.0]] == pytest.approx(50.0)
    assert amplitude[at[50.0], [early, late]] == pytest.approx(0.5, rel=1e-3)
    assert amplitude[at[120.0], late] == pytest.approx(2.0, rel=1e-3)
    assert amplitude[at[120.0], early] < 1e-3
    assert time.size == pytest.approx(40, abs=2)
    assert amplitude.shape == (frequency.size, time.size)


def test_a_record_shorter_than_the_window_has_one_as_long_as_itself():
    time, frequency, amplitude = spectrogram(np.ones(100), RATE, 0.5, 10)
    assert frequency[-1] == pytest.approx(0.5 * RATE)
    assert np.all(np.isfinite(amplitude))
    assert time[0] == 0.0
