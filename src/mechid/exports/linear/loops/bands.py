"""Numbers of a closed loop with their band over draws: margins, Bode diagram, step response."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.exports.linear.loops.closing import Loop
from mechid.exports.linear.loops.margins import Margins, loop_frequencies, margins_of, unstable_pole
from mechid.exports.linear.loops.sampled import Sampled

LEVELS = (0.025, 0.975)
"""Ends of the band of 95 %."""
SHOWN = 160
"""Most instants of a step response."""
TIME_CONSTANTS, MOST_STEPS = 6.0, 6000
"""Length of a step response, in time constants of the slowest pole, and in samples."""
SETTLED = 0.02
"""Largest deviation from the end value of a settled response, relative to the step."""


@dataclass(frozen=True, eq=False)
class Band:
    """Nominal curve or number, with the ends of its band over the draws.

    Attributes
    ----------
    value, low, high : (n,) or ()
    """

    value: FloatArray
    low: FloatArray
    high: FloatArray

    def to_dict(self) -> dict[str, Any]:
        """Return nested lists; null for infinite values."""
        return {field.name: _finite(getattr(self, field.name).tolist()) for field in fields(self)}


def band_of(value: Any, draws: Any) -> Band:
    """Return the band of 95 % of draws, (N, ...), about a nominal value; without draws it is the value."""
    value, draws = np.asarray(value, dtype=np.float64), np.asarray(draws, dtype=np.float64)
    if not len(draws):
        return Band(value, value, value)
    # Whole draws, not means of two: one of them may be infinite.
    low = np.quantile(draws, LEVELS[0], axis=0, method="lower")
    high = np.quantile(draws, LEVELS[1], axis=0, method="higher")
    return Band(value, np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64))


@dataclass(frozen=True, eq=False)
class LoopNumbers:
    """Margins, Bode diagram and stability of a loop.

    Attributes
    ----------
    margins : Margins
        Nominal margins.
    bands : mapping of str to Band
        Bands of the margins, by their names.
    unstable_draws, draws : int
        Draws whose closed loop is unstable, and all draws. In the bands of gain and phase margin an unstable draw
        counts with the negative of its smallest distance.
    frequency_hz : (f,)
    magnitude_dB, phase_deg : Band, (f,)
        Open loop.
    """

    margins: Margins
    bands: dict[str, Band]
    unstable_draws: int
    draws: int
    frequency_hz: FloatArray
    magnitude_dB: Band
    phase_deg: Band

    def to_dict(self) -> dict[str, Any]:
        """Return the content of linear.json."""
        return {
            "margins": {**self.margins.to_dict(), "band": {name: band.to_dict() for name, band in self.bands.items()}},
            "draws": self.draws,
            "unstable_draws": self.unstable_draws,
            "bode": {
                "frequency_hz": self.frequency_hz.tolist(),
                "magnitude_dB": self.magnitude_dB.to_dict(),
                "phase_deg": self.phase_deg.to_dict(),
            },
        }


def loop_numbers(nominal: Loop, draws: Sequence[Loop]) -> LoopNumbers:
    """Return the numbers of a loop, with bands over the same loop around drawn plants."""
    own, stable = margins_of(nominal.open), [unstable_pole(loop.closed) is None for loop in draws]
    drawn = [_sign_unstable(margins_of(loop.open), ok) for loop, ok in zip(draws, stable, strict=True)]
    bands = {
        name: band_of(getattr(own, name), [getattr(one, name) for one in drawn])
        for name in ("gain_dB", "reduction_dB", "phase_deg", "delay_s", "sensitivity_peak")
    }
    hertz = loop_frequencies(nominal.open)
    curves = [loop.open.response(hertz)[:, 0, 0] for loop in (nominal, *draws)]
    size = np.array([20.0 * np.log10(np.maximum(np.abs(curve), 1e-300)) for curve in curves])
    phase = np.degrees(np.unwrap(np.angle(curves), axis=1))
    # A draw may begin a turn away.
    phase -= 360.0 * np.round((phase[:, :1] - phase[0, 0]) / 360.0)
    return LoopNumbers(
        margins=own,
        bands=bands,
        unstable_draws=stable.count(False),
        draws=len(draws),
        frequency_hz=hertz,
        magnitude_dB=band_of(size[0], size[1:]),
        phase_deg=band_of(phase[0], phase[1:]),
    )


@dataclass(frozen=True, eq=False)
class StepResponse:
    """Response of outputs to a step of a reference.

    Attributes
    ----------
    time_s : (t,)
    outputs : mapping of str to Band, (t,)
    overshoot : Band
        Largest excess of the leading output over its end value, relative to the step.
    settling_s : Band
        Time from which it stays within 2 % of the step about its end value.
    """

    time_s: FloatArray
    outputs: dict[str, Band]
    overshoot: Band
    settling_s: Band

    def to_dict(self) -> dict[str, Any]:
        """Return the content of linear.json."""
        return {
            "time_s": self.time_s.tolist(),
            "outputs": {name: band.to_dict() for name, band in self.outputs.items()},
            "overshoot": self.overshoot.to_dict(),
            "settling_s": self.settling_s.to_dict(),
        }


def step_response(nominal: Sampled, draws: Sequence[Sampled], reference: str, outputs: Sequence[str]) -> StepResponse:
    """Return the response to a unit step of a reference; the first of `outputs` leads."""
    count = _step_samples(nominal, reference, outputs[0])
    every = _step_all([one.select((reference,), outputs) for one in (nominal, *draws)], count)
    lead, times = every[:, :, 0], np.arange(count) * nominal.period_s
    end = lead[:, -1:]
    over = np.maximum(np.max(lead - end, axis=1), 0.0)
    outside = np.abs(lead - end) > SETTLED
    settled = np.where(outside.any(axis=1), count - np.argmax(outside[:, ::-1], axis=1), 0) * nominal.period_s
    shown = np.unique(np.round(np.linspace(0, count - 1, min(SHOWN, count))).astype(int))
    return StepResponse(
        time_s=times[shown],
        outputs={name: band_of(every[0, shown, k], every[1:, shown, k]) for k, name in enumerate(outputs)},
        overshoot=band_of(over[0], over[1:]),
        settling_s=band_of(settled[0], settled[1:]),
    )


def _step_samples(closed: Sampled, reference: str, output: str) -> int:
    """Return the length of a step response in samples: some time constants of the slowest pole that it shows."""
    A, B, C, _ = closed.select((reference,), (output,)).matrices.all
    values, vectors = np.linalg.eig(A)
    try:
        weights = np.abs((C @ vectors)[0] * np.linalg.solve(vectors, B[:, 0] + 0j))
    except np.linalg.LinAlgError:
        weights = np.ones(len(A))
    # An integrator of gain 0 stays at z = 1, unseen.
    weights /= np.maximum(np.abs(1.0 - values), 1e-9)
    seen = (weights > 1e-3 * weights.max()) & (np.abs(values) < 1.0 - 1e-9) & (np.abs(values) > 0.0)
    slowest = float(np.abs(values[seen]).max(initial=0.1))
    return int(min(max(TIME_CONSTANTS / -math.log(slowest), 20.0), MOST_STEPS)) + 1


def _step_all(systems: Sequence[Sampled], count: int) -> FloatArray:
    """Return the outputs of systems of one size under a unit step, (N, count, n_y)."""
    A, B, C, D = (np.array([one.matrices.all[k] for one in systems]) for k in range(4))
    x, out = np.zeros((len(systems), A.shape[1], 1)), np.empty((count, len(systems), C.shape[1], 1))
    for k in range(count):
        out[k] = C @ x + D
        x = A @ x + B
    return np.asarray(np.swapaxes(out[..., 0], 0, 1), dtype=np.float64)


def _sign_unstable(margins: Margins, stable: bool) -> Margins:
    """Return margins whose gain and phase are negative for an unstable loop."""
    if stable:
        return margins
    nearest = min(margins.gain_dB, margins.reduction_dB)
    values = {field.name: getattr(margins, field.name) for field in fields(margins)}
    return Margins(**{**values, "gain_dB": -nearest, "phase_deg": -abs(margins.phase_deg), "delay_s": 0.0})


def _finite(values: Any) -> Any:
    """Return nested lists with None instead of infinite values."""
    if isinstance(values, list):
        return [*map(_finite, values)]
    return values if math.isfinite(values) else None
