r"""Pointing error indices and what each keeps of a spectrum.

ECSS-E-ST-60-10C, 3.2, defines them in time, on an error e(t) and a window of T around it:

- APE, absolute: e(t)
- MPE, mean: the mean of e over a window
- RPE, relative: e(t) less its mean over the window that holds t
- PDE, drift: the difference of two means, their windows a separation apart in one observation period
- PRE, reproducibility: the same of windows in different observation periods

For a stationary error the variance of each is the integral of its spectrum by a weight, with
s = sin(pi f T)/(pi f T) [Lucke1992]_, which ESSB-HB-E-003, 8.2, takes over:

    APE 1,   MPE s^2,   RPE 1 - s^2,   PDE and PRE 4 sin^2(pi f S) s^2

RPE's weight is its average over the instants of a window. At one instant, tau from the window's centre, it is
1 + s^2 - 2 s cos(2 pi f tau); a distribution needs that (`gains`).

.. [Lucke1992] Lucke, Sirlin, San Martin, New Definitions of Pointing Stability: AC and DC Effects, The Journal of the
   Astronautical Sciences 40(4), 1992.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mechid.errors import InputFileError, did_you_mean

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

KINDS = ("APE", "MPE", "RPE", "PDE", "PRE")


@dataclass(frozen=True)
class Index:
    """One pointing error index.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    window_s : float
        T, s; 0 for APE.
    separation_s : float
        S from window to window, s; for PDE and PRE.

    Raises
    ------
    InputFileError
        The kind is unknown, or a time is missing or one that it has not.
    """

    kind: str
    window_s: float = 0.0
    separation_s: float = 0.0

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            near = did_you_mean(self.kind.upper(), KINDS) or f"; write one of {', '.join(KINDS)}"
            raise InputFileError(f'index: unknown "{self.kind}"{near}')
        if (self.kind != "APE") != (self.window_s > 0.0):
            need = "has no window" if self.kind == "APE" else "needs window_s, above 0"
            raise InputFileError(f"window_s: found {self.window_s:.9g}; {self.kind} {need}")
        if (self.kind in ("PDE", "PRE")) != (self.separation_s > 0.0):
            need = "needs separation_s, above 0" if self.kind in ("PDE", "PRE") else "has no separation"
            raise InputFileError(f"separation_s: found {self.separation_s:.9g}; {self.kind} {need}")

    @property
    def keeps_bias(self) -> bool:
        """Whether a constant error counts."""
        return self.kind in ("APE", "MPE")

    @property
    def longest_s(self) -> float:
        """Time from the first to the last instant that it needs, s."""
        return self.window_s + self.separation_s

    def weight(self, frequency_hz: FloatArray) -> FloatArray:
        """Return the share of the variance at each frequency that the index keeps, (n,); up to 4 for PDE, PRE."""
        s = np.sinc(frequency_hz * self.window_s)
        if self.kind == "APE":
            return np.ones_like(frequency_hz)
        if self.kind == "MPE":
            return np.asarray(s**2)
        if self.kind == "RPE":
            return np.asarray(1.0 - s**2)
        return np.asarray(4.0 * np.sin(np.pi * frequency_hz * self.separation_s) ** 2 * s**2)

    def gains(self, frequency_hz: FloatArray, position: FloatArray) -> ComplexArray:
        """Return by what a line's phasor is multiplied, (p, n).

        Parameters
        ----------
        frequency_hz : (n,)
        position : (p,)
            Instants in the window, -1/2 to 1/2 of it, at which RPE is looked at; the others do not depend on it.
        """
        f = frequency_hz[None, :]
        s = np.sinc(f * self.window_s)
        if self.kind == "RPE":
            return np.asarray(np.exp(2j * np.pi * f * self.window_s * position[:, None]) - s)
        if self.kind in ("PDE", "PRE"):
            s = (np.exp(2j * np.pi * f * self.separation_s) - 1.0) * s
        gain = np.ones_like(f) if self.kind == "APE" else s
        return np.broadcast_to(gain.astype(np.complex128), (position.size, frequency_hz.size))

    def variance(self, frequency_hz: FloatArray, density: FloatArray) -> float:
        """Return the index's variance of a one-sided density, (n,) unit^2/Hz at equal steps of frequency."""
        step = float(frequency_hz[1] - frequency_hz[0])
        return float(np.sum(self.weight(frequency_hz) * density) * step)
