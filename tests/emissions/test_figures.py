"""Figures of an emission verdict. Truth: the spectra that they are drawn of."""

import numpy as np
import pytest

from mechid.emissions.emission import EmissionSpectrum
from mechid.emissions.figures import envelope_of, rates_of


def spectrum(frequency, amplitude):
    f, a = np.array(frequency), np.array(amplitude)
    return EmissionSpectrum(
        record="a", rate=1.0, direction="fx", unit="N", bin_hz=1.0, frequency_hz=f, amplitude=a, density=a**2
    )


def test_the_envelope_is_the_largest_at_each_frequency():
    """Truth: the second spectrum has other bins; between them it is a straight line."""
    one, other = spectrum([1.0, 2.0, 3.0], [1.0, 5.0, 1.0]), spectrum([1.0, 3.0], [2.0, 4.0])
    frequency, largest = envelope_of([one, other])
    assert frequency.tolist() == [1.0, 2.0, 3.0]
    assert largest == pytest.approx([2.0, 5.0, 4.0])


def test_rates_without_a_value_are_left_out():
    rows = [
        {"rate": 2.0, "worst": {}},
        {"rate": None, "worst": {}},
        {"rate": 1.0, "worst": {}},
        {"rate": 3.0, "worst": None},
    ]
    assert rates_of(rows) == [1.0, 2.0]
