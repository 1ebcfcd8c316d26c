"""Plain numerics on arrays of samples: spectra and noise."""

from mechid.signal.noise import noise_floor
from mechid.signal.spectrum import amplitude_spectrum, line_amplitude

__all__ = ["amplitude_spectrum", "line_amplitude", "noise_floor"]
