"""Stability margins of a sampled open loop L with negative feedback, 1 + L = 0.

- gain margin: 1/|L| where L is real and negative (phase crossover), in dB; the smallest above 0 dB is the increase that
  the loop bears, the largest below 0 dB the decrease, if there is one;
- phase margin: 180 deg + arg L where |L| = 1 (gain crossover), the one of smallest magnitude;
- delay margin: the further delay that turns L at a gain crossover to -1, the least over the crossovers;
- sensitivity peak: the maximum of 1/|1 + L|, the reciprocal of the distance to -1.

They are those of the response at the samples, L(exp(i w T)), from 0 to half the sample rate, both ends included (K. J.
Astrom, R. M. Murray, Feedback Systems, 2nd ed., 2021, section 10.3).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np
from scipy.optimize import brentq

from mechid.arrays import ComplexArray, FloatArray
from mechid.exports.linear.loops.sampled import Sampled

POINTS = 240
"""Frequencies of the plain grid, evenly spaced in the logarithm."""
BELOW = 1e-2
"""Lowest frequency, as a share of that of the slowest pole."""
ABOVE_ONE = 10.0
"""Least gain of a loop with an integrator at the lowest frequency."""
LIGHT, CLOSE = 0.3, np.array([-3.0, -2.0, -1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 1.0, 2.0, 3.0])
"""Damping ratio below which a pole has its own frequencies, and their distances from it in half-widths."""
STABLE = 1.0 + 1e-9
"""Largest magnitude of a pole of a stable loop: rounding moves the poles of undamped loads."""
Scalar = Callable[[float], complex]


@dataclass(frozen=True, kw_only=True)
class Margins:
    """Margins of a loop; infinite without a crossover, frequencies then NaN.

    Attributes
    ----------
    gain_dB, gain_frequency_hz : float
        Largest bearable increase of the gain, and its phase crossover.
    reduction_dB : float
        Largest bearable decrease, above 0 dB.
    phase_deg, phase_frequency_hz : float
        Phase margin and its gain crossover.
    delay_s : float
    sensitivity_peak : float
    """

    gain_dB: float
    gain_frequency_hz: float
    reduction_dB: float
    phase_deg: float
    phase_frequency_hz: float
    delay_s: float
    sensitivity_peak: float

    def to_dict(self) -> dict[str, float | None]:
        """Return the margins; null where they are infinite or without a crossover."""
        return {name: value if math.isfinite(value) else None for name, value in asdict(self).items()}


def margins_of(loop: Sampled) -> Margins:
    """Return the margins of an open loop with one input and one output."""
    hertz = loop_frequencies(loop)
    return margins_on_grid(
        hertz,
        loop.response(hertz)[:, 0, 0],
        lambda f: complex(loop.response([f])[0, 0, 0]),
        # With an integrator there is no response at 0.
        (loop.nyquist_hz,) if _integrates(loop) else (0.0, loop.nyquist_hz),
    )


def margins_on_grid(
    hertz: FloatArray, response: ComplexArray, exact: Scalar, real_hz: tuple[float, ...] = ()
) -> Margins:
    """Return the margins from a response on a grid.

    Parameters
    ----------
    hertz, response : (f,)
    exact : callable
        Response at any frequency in Hz.
    real_hz : tuple of float
        Frequencies at which the response is real by symmetry, the ends of the range.
    """
    phase_hz = _phase_crossovers(hertz, response, exact) + [f for f in real_hz if exact(f).real < 0.0]
    rises = {f: -20.0 * math.log10(abs(exact(f))) for f in phase_hz}
    up = min((f for f, dB in rises.items() if dB >= 0.0), key=rises.__getitem__, default=math.nan)
    gain_hz = _crossings(hertz, np.log(np.abs(response)), lambda f: math.log(abs(exact(f))))
    phases = {f: math.degrees(np.angle(-exact(f))) for f in gain_hz}
    least = min(phases, key=lambda f: abs(phases[f]), default=math.nan)
    return Margins(
        gain_dB=rises.get(up, math.inf),
        gain_frequency_hz=up,
        reduction_dB=min((-dB for dB in rises.values() if dB < 0.0), default=math.inf),
        phase_deg=phases.get(least, math.inf),
        phase_frequency_hz=least,
        delay_s=min((phases[f] % 360.0 / 360.0 / f for f in gain_hz), default=math.inf),
        sensitivity_peak=float(1.0 / np.abs(1.0 + response).min()),
    )


def loop_frequencies(loop: Sampled) -> FloatArray:
    """Return frequencies up to half the sample rate, (f,) Hz, closely spaced about lightly damped poles."""
    poles = loop.poles
    # A pole at z = 0 is a delay, one at z = 1 an integrator: neither has a frequency.
    poles = poles[(np.abs(poles) > 1e-6) & (np.abs(poles - 1.0) > 1e-9)]
    s = np.log(poles) / loop.period_s
    natural, half = np.abs(s) / (2.0 * np.pi), loop.nyquist_hz
    lowest = BELOW * min(float(natural.min(initial=half)), half)
    if _integrates(loop):
        # An integrator crosses |L| = 1 somewhere below, however small its gain.
        lowest *= min(float(np.abs(loop.response([lowest])).min()) / ABOVE_ONE, 1.0)
    own = [np.geomspace(lowest, half, POINTS)]
    for f, one in zip(natural, s, strict=True):
        damping = max(-one.real / abs(one), 1e-6)
        if damping < LIGHT and one.imag > 0.0:
            own.append(f * (1.0 + damping * CLOSE))
    every = np.unique(np.concatenate(own))
    return every[(every > 0.0) & (every <= half)]


def _integrates(loop: Sampled) -> bool:
    return bool(np.any(np.abs(loop.poles - 1.0) < 1e-9))


def _phase_crossovers(hertz: FloatArray, response: ComplexArray, exact: Scalar) -> list[float]:
    """Return the frequencies within the range at which L is real and negative."""
    inside = slice(0, -1)  # at half the sample rate the sign of an imaginary part of 0 is rounding
    found = _crossings(hertz[inside], response[inside].imag, lambda f: exact(f).imag)
    return [f for f in found if exact(f).real < 0.0]


def _crossings(hertz: FloatArray, values: FloatArray, exact: Callable[[float], float]) -> list[float]:
    """Return the frequencies at which a function changes its sign."""
    at = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0.0)
    return [float(brentq(exact, hertz[k], hertz[k + 1], xtol=1e-9 * hertz[k], rtol=1e-12)) for k in at]


def unstable_pole(closed: Sampled) -> complex | None:
    """Return the pole of a closed loop that is farthest outside the unit circle, with Im >= 0; None if it is stable."""
    worst = max(closed.poles.tolist(), key=abs, default=0j)
    return complex(worst.real, abs(worst.imag)) if abs(worst) > STABLE else None
