"""Curves of a record. Truth: NumPy's transform of it, and the rate that was commanded."""

import numpy as np
import pytest
from scipy.fft import prev_fast_len

from mechid.analysis.prediction import predict
from mechid.reports.curves import record_curves


def test_the_spectrum_has_the_lines_of_the_step_rate(reported):
    """Published: lines at 46, 92 and 138 Hz; truth: NumPy's transform of the record, its last sample left out."""
    (curves,) = record_curves(reported.campaign, reported.fit, reported.validation["full_46"])
    p = predict(reported.campaign.record("full_46"), reported.fit)["torque"]
    y = (p.measured - p.removed.at(0, p.measured.size))[: prev_fast_len(p.measured.size, real=True)]
    assert p.measured.size - 5 < y.size
    amplitude = 2.0 * np.abs(np.fft.rfft(y)) / y.size
    for frequency in (46.0, 92.0, 138.0):
        near = np.abs(curves.spectrum_hz - frequency) < 2.0
        bins = np.abs(np.fft.rfftfreq(y.size, 1e-4) - frequency) < 2.0
        assert curves.measured[near].max() == pytest.approx(amplitude[bins].max(), rel=1e-9)
        assert curves.measured[near].max() > 5.0 * curves.residual[near].max()


def test_the_curves_of_a_sweep_know_its_rate(reported):
    (curves,) = record_curves(reported.campaign, reported.fit, reported.validation["sweep"])
    assert curves.rate.tolist() == [[0.0, 0.0], [pytest.approx(2.0), pytest.approx(60.0)]]
    assert curves.spectrogram.measured.shape == curves.spectrogram.modelled.shape
