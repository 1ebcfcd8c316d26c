"""Plausibility checks of transfer functions: passivity, causality, resolution and rigid-body behaviour."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mechid.arrays import BoolArray, ComplexArray, FloatArray
from mechid.errors import InputFileError

LARGEST_RECEPTANCE = 1e100
"""Upper bound of the receptance of any structure, in rad/(N m); products of such values do not overflow."""
ACTIVE_IN_MODELS, ACTIVE_IN_MEASUREMENTS = 1e-9, 0.02
"""Tolerated positive imaginary part of a receptance, relative to its magnitude: rounding errors, and noise."""
NONCAUSAL_SHARE = 0.1
"""Share of the impulse response's energy before the impulse from which a response is reported as not causal."""
SMEAR = 4.0
"""Guard interval around zero time, in widths of the band-limited impulse."""
MAX_POINTS = 1 << 16


def refuse_overflow(place: str, frequency_hz: FloatArray, lost: BoolArray) -> None:
    """Raise an error if responses are lost to overflow or beyond `LARGEST_RECEPTANCE`.

    Parameters
    ----------
    place : str
        Location in the file, for the message.
    frequency_hz : (n,)
    lost : (n, ...) of bool
        Mask of the unusable values.

    Raises
    ------
    InputFileError
        Some values are unusable.
    """
    if lost.any():
        at = frequency_hz[lost.reshape(frequency_hz.size, -1).any(axis=1)][0]
        raise InputFileError(
            f"{place}: its response at {at:.6g} Hz is not finite or is too large for a structure; check the "
            "frequencies and shapes of its modes, or the responses, and their units"
        )


def model_findings(frequency_hz: FloatArray, values: ComplexArray) -> Iterator[str]:
    """Yield warnings about a model's responses, (n, 1 + m), the driving point first."""
    yield from passivity_finding(frequency_hz, values[:, 0], ACTIVE_IN_MODELS)


def response_findings(frequency_hz: FloatArray, values: ComplexArray, names: tuple[str, ...]) -> Iterator[str]:
    """Yield warnings about measured or exported responses, (n, 1 + m), the driving point first; m `names`."""
    yield from passivity_finding(frequency_hz, values[:, 0], ACTIVE_IN_MEASUREMENTS)
    for name, column in zip(("interface", *names), values.T, strict=True):
        if np.isfinite(column).all():
            yield from _causality_finding(frequency_hz, column, name)
            yield from _resolution_finding(frequency_hz, column, name)
            yield from _rigid_body_finding(frequency_hz, column, name)


def passivity_finding(frequency_hz: FloatArray, receptance: ComplexArray, tolerance: float) -> Iterator[str]:
    """Yield a warning if the driving point generates power: Im H > 0, since Re(i w H) = -w Im H.

    Parameters
    ----------
    frequency_hz : (n,)
    receptance : (n,) complex
        Rotation per torque at one point and axis, rad/(N m); NaN is ignored.
    tolerance : float
        Tolerated imaginary part, relative to the magnitude.
    """
    known = np.isfinite(receptance) & (frequency_hz > 0.0)
    f, h = frequency_hz[known], receptance[known]
    active = h.imag > tolerance * np.abs(h)
    if active.any():
        worst = f[active][np.argmax(h.imag[active] / np.abs(h[active]))]
        share = 100.0 * active.mean()
        yield (
            f"the driving point is not passive at {share:.2g} % of its frequencies, most at {worst:.6g} Hz; check that "
            "torque and rotation have the same point, axis and sense, and the sign of the phase"
        )


def energy_before_impulse(frequency_hz: FloatArray, receptance: ComplexArray) -> float:
    """Return the share of a response's energy before the impulse, 0 to 1.

    The accelerance, which remains finite for a free body, is band-limited by a Hann window and transformed. The
    band-limited impulse itself, whose width is the reciprocal of the bandwidth, is excluded.

    Parameters
    ----------
    frequency_hz : (n,)
        Ascending.
    receptance : (n,) complex
    """
    low, high = frequency_hz[0], frequency_hz[-1]
    # The transform needs a uniform grid; it is as fine as the closest pair of points, to keep narrow resonances.
    points = min(MAX_POINTS, max(frequency_hz.size, round((high - low) / np.diff(frequency_hz).min()) + 1))
    f = np.linspace(low, high, points)
    accelerance = np.interp(f, frequency_hz, -((2.0 * np.pi * frequency_hz) ** 2) * receptance)
    energy = np.abs(np.fft.ifft(accelerance * np.hanning(points), 2 * points)) ** 2
    guard = int(2 * SMEAR)
    after, before = energy[guard:points].sum(), energy[points : 2 * points - guard].sum()
    # Without a resonance only the impulse has energy, and the ratio would be one of rounding errors.
    return float(before / (before + after)) if before + after > 1e-12 * energy.sum() else 0.0


def _causality_finding(frequency_hz: FloatArray, column: ComplexArray, name: str) -> Iterator[str]:
    share = energy_before_impulse(frequency_hz, column)
    if share > 0.5:
        yield (
            f"{name}: {100.0 * share:.0f} % of the impulse response comes before the impulse; the phase has the "
            "opposite sign: take the complex conjugate"
        )
    elif share > NONCAUSAL_SHARE:
        yield (
            f"{name}: {100.0 * share:.0f} % of the impulse response comes before the impulse; the response is not "
            "causal, or its points are too far apart for its damping"
        )


def _resolution_finding(frequency_hz: FloatArray, column: ComplexArray, name: str) -> Iterator[str]:
    size = np.abs(column)
    peak = (size[1:-1] > 2.0 * size[:-2]) & (size[1:-1] > 2.0 * size[2:])
    if peak.any():
        at = frequency_hz[1:-1][peak][np.argmax(size[1:-1][peak])]
        yield f"{name}: the resonance at {at:.6g} Hz has one point above half its height; export it with finer spacing"


def _rigid_body_finding(frequency_hz: FloatArray, column: ComplexArray, name: str) -> Iterator[str]:
    f, size = frequency_hz[frequency_hz > 0.0][:2], np.abs(column[frequency_hz > 0.0][:2])
    # The logarithmic slope of a free body is -2; the limit leaves a margin.
    if np.all(size > 0.0) and np.log(size[1] / size[0]) / np.log(f[1] / f[0]) < -1.8:
        yield (
            f"{name}: rises as 1/f^2 towards {f[0]:.6g} Hz, as a free body does; below it absolute and drift errors "
            "need the attitude control in the response"
        )
