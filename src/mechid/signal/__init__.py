"""Plain numerics on arrays of samples: spectra, orders, noise, and how well a prediction agrees."""

from mechid.signal.agreement import TheilInequality, fit_percent, theil_inequality
from mechid.signal.autoregression import autocorrelation
from mechid.signal.density import Band, power_density, third_octaves
from mechid.signal.envelope import envelope, peak_groups
from mechid.signal.noise import noise_floor
from mechid.signal.orders import order_amplitudes, order_signal
from mechid.signal.spectrogram import spectrogram
from mechid.signal.spectrum import amplitude_spectrum, line_amplitude, peak_spectrum
from mechid.signal.whiteness import LjungBox, effective_samples, effective_samples_of, ljung_box

__all__ = [
    "Band",
    "LjungBox",
    "TheilInequality",
    "amplitude_spectrum",
    "autocorrelation",
    "effective_samples",
    "effective_samples_of",
    "envelope",
    "fit_percent",
    "line_amplitude",
    "ljung_box",
    "noise_floor",
    "order_amplitudes",
    "order_signal",
    "peak_groups",
    "peak_spectrum",
    "power_density",
    "spectrogram",
    "theil_inequality",
    "third_octaves",
]
