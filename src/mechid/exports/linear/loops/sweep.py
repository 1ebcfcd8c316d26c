"""Margins from a swept sine through the nonlinear equations, beside those of the linear loop."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from mechid.arrays import ComplexArray, FloatArray
from mechid.errors import FitError
from mechid.exports.linear.loops.closing import Loop
from mechid.exports.linear.loops.loop_file import LoopDesign
from mechid.exports.linear.loops.margins import Margins, loop_frequencies, margins_of, margins_on_grid
from mechid.exports.linear.loops.sample_by_sample import NonlinearPlant, measure_loop

ABOUT = (0.5, 0.8, 1.0, 1.25, 1.6)
"""Frequencies of the sweep relative to each crossover."""
HIGHEST = 0.95
"""Highest frequency, as a share of half the sample rate."""
SHARE = 0.01
"""Largest change of a current, relative to the held current."""
PER_RUN = 12.0
"""Least samples of a run, in which several cycles of a fast sine fit."""
MOST_SAMPLES = 20_000
"""Most samples of the fastest controller in a run; slower sines are left out."""
GAIN_DB, PHASE_DEG = 0.3, 1.0
"""Largest accepted errors of the margins."""


@dataclass(frozen=True, eq=False)
class Sweep:
    """Loop measured by single sines through the nonlinear equations.

    Attributes
    ----------
    frequency_hz : (f,)
    response, linear : (f,) complex
        Open loop as measured, and of the linear model.
    margins : Margins
        Margins of the measured loop.
    gain_error_dB, phase_error_deg : float
        Margins of the measured loop minus those of the linear one; 0 where both are unlimited.
    """

    frequency_hz: FloatArray
    response: ComplexArray
    linear: ComplexArray
    margins: Margins
    gain_error_dB: float
    phase_error_deg: float

    def to_dict(self) -> dict[str, Any]:
        """Return the content of linear.json."""
        off = self.response / self.linear
        return {
            "frequency_hz": self.frequency_hz.tolist(),
            "magnitude_error_dB": (20.0 * np.log10(np.abs(off))).tolist(),
            "phase_error_deg": np.degrees(np.angle(off)).tolist(),
            "gain_margin_error_dB": self.gain_error_dB,
            "phase_margin_error_deg": self.phase_error_deg,
        }


def sweep_loop(
    plant: NonlinearPlant, design: LoopDesign, loop: Loop, driven: str, share: float = SHARE
) -> Sweep | None:
    """Measure a loop around its crossovers; None if it has none that a run reaches.

    Parameters
    ----------
    plant : NonlinearPlant
    design : LoopDesign
    loop : Loop
    driven : str
        Input whose controller is measured.
    share : float
        Largest change of a current, relative to the held current.
    """
    own, period_s = margins_of(loop.open), loop.open.period_s
    every = round(period_s / design.current.timing.period_s) if design.current else 1
    runs = _runs(own, loop.open.nyquist_hz, period_s, MOST_SAMPLES // max(every, 1))
    if not runs:
        return None
    hertz = np.array(sorted(runs))
    found = np.array([measure_loop(plant, design, loop, driven, *runs[f], share) for f in hertz.tolist()])
    linear = loop.open.response(hertz)[:, 0, 0]
    margins = _corrected_margins(loop, hertz, found / linear)
    return Sweep(
        frequency_hz=hertz,
        response=found,
        linear=linear,
        margins=margins,
        gain_error_dB=_difference(margins.gain_dB, own.gain_dB),
        phase_error_deg=_difference(margins.phase_deg, own.phase_deg),
    )


def refuse_departure(sweep: Sweep, words: str) -> None:
    """Raise FitError if the margins of the nonlinear equations are not those of the linear loop."""
    if abs(sweep.gain_error_dB) > GAIN_DB or abs(sweep.phase_error_deg) > PHASE_DEG:
        raise FitError(
            f"{words}: a swept sine through the nonlinear equations finds margins that differ by "
            f"{sweep.gain_error_dB:.2g} dB and {sweep.phase_error_deg:.2g} deg: the mechanism is not linear at its "
            "rest point; hold it at another start angle"
        )


def _runs(own: Margins, half: float, period_s: float, most: int) -> dict[float, tuple[int, int]]:
    """Return cycles and samples of each run, by its frequency in Hz."""
    runs = {}
    for crossover in (own.gain_frequency_hz, own.phase_frequency_hz):
        if not math.isfinite(crossover) or crossover == 0.0:
            continue
        for share in ABOUT:
            turn = min(crossover * share, HIGHEST * half) * period_s
            cycles = max(math.ceil(PER_RUN * turn), 1)
            samples = round(cycles / turn)
            if samples <= most:
                runs[cycles / samples / period_s] = (cycles, samples)
    return runs


def _corrected_margins(loop: Loop, hertz: FloatArray, ratio: ComplexArray) -> Margins:
    """Return the margins of the linear loop times the measured ratio, interpolated over the frequency."""
    size, angle = np.log(np.abs(ratio)), np.angle(ratio)

    def factor(f: FloatArray | float) -> Any:
        return np.exp(np.interp(f, hertz, size) + 1j * np.interp(f, hertz, angle))

    def exact(f: float) -> complex:
        return complex(loop.open.response([f])[0, 0, 0] * factor(f))

    grid = loop_frequencies(loop.open)
    return margins_on_grid(grid, loop.open.response(grid)[:, 0, 0] * factor(grid), exact, (loop.open.nyquist_hz,))


def _difference(found: float, own: float) -> float:
    return found - own if math.isfinite(found) or math.isfinite(own) else 0.0
