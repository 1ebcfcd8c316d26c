"""Signal analysis of sample arrays: spectra, orders, noise floors, and measures of agreement.

Names are imported from their modules on first use, because the reading process needs only a few of them. The functions
`envelope` and `spectrogram` share the names of their modules and are imported from there.

Internal to mechid except for the names listed in docs/python.md.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mechid.signal.agreement import TheilInequality, fit_percent, theil_inequality
    from mechid.signal.autoregression import autocorrelation
    from mechid.signal.density import Band, power_density, third_octaves
    from mechid.signal.envelope import peak_groups
    from mechid.signal.noise import noise_floor
    from mechid.signal.orders import order_amplitudes, order_signal
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
    "fit_percent",
    "line_amplitude",
    "ljung_box",
    "noise_floor",
    "order_amplitudes",
    "order_signal",
    "peak_groups",
    "peak_spectrum",
    "power_density",
    "theil_inequality",
    "third_octaves",
]

_HOMES = {
    "Band": "density",
    "LjungBox": "whiteness",
    "TheilInequality": "agreement",
    "amplitude_spectrum": "spectrum",
    "autocorrelation": "autoregression",
    "effective_samples": "whiteness",
    "effective_samples_of": "whiteness",
    "fit_percent": "agreement",
    "line_amplitude": "spectrum",
    "ljung_box": "whiteness",
    "noise_floor": "noise",
    "order_amplitudes": "orders",
    "order_signal": "orders",
    "peak_groups": "envelope",
    "peak_spectrum": "spectrum",
    "power_density": "density",
    "theil_inequality": "agreement",
    "third_octaves": "density",
}


def __getattr__(name: str) -> object:
    """Import a public name from its module on first use."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value: object = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    # Stored so that the next access finds the name without this function.
    globals()[name] = value
    return value
