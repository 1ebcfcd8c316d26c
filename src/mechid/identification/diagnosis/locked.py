"""What is known of a residual that nothing explains: whether it goes with the motor's motion or with time.

Only a record whose rate varies tells the two apart: there what goes with the motion has lines over the position, the
residual taken at equal steps of it, and what goes with time has lines over time.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.command import MeasuredCommand
from mechid.command.edges import steps_travelled
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.diagnosis.settings import DIAGNOSIS
from mechid.identification.output_error.misfit import misfit_series
from mechid.identification.output_error.target import Target
from mechid.signal.lines import Line, prominence, spectral_lines
from mechid.signal.orders import order_amplitudes, order_signal


@dataclass(frozen=True, kw_only=True)
class Locked:
    """Lines that a residual has over position or over time.

    Attributes
    ----------
    record : str
    orders : tuple of float
        Multiples of the full-step rate, the strongest first; empty of lines over time.
    frequencies_hz : tuple of float
        Empty of lines over position.
    share : float
        Of the residual's power that is in these lines.
    """

    record: str
    orders: tuple[float, ...] = ()
    frequencies_hz: tuple[float, ...] = ()
    share: float

    @property
    def words(self) -> str:
        """A sentence."""
        if self.orders:
            numbers = ", ".join(f"{order:.4g}" for order in self.orders)
            how = f"goes with the motor's motion, at {numbers} times the full-step rate"
        else:
            how = f"is at {', '.join(f'{hz:.4g}' for hz in self.frequencies_hz)} Hz, whatever the rate"
        return f"Of what is left of record {self.record} {100.0 * self.share:.0f} % {how}."


def locked(model: Model) -> tuple[Locked, ...]:
    """Return what the residuals of records with a varying rate go with, at a model's optimum."""
    varying = [t for t in model.problem.targets if t.name in model.setting.windows and _varies(t)]
    return tuple(one for target in varying for one in _of(model, target) if one.share >= DIAGNOSIS.least_line_share)


def _varies(target: Target) -> bool:
    return not isinstance(target.command, MeasuredCommand) and len(set(target.command.rate.rates)) > 1


def _of(model: Model, target: Target) -> Iterator[Locked]:
    """Yield what a residual goes with most, and what is left without that goes with else."""
    window = model.setting.windows[target.name]
    residual = misfit_series(model.problem.model, target, model.q, window)[0][:]
    if not np.all(np.isfinite(residual)):
        return
    time = target.base.start_s + np.arange(residual.size) / target.base.sample_rate_hz - target.time_offset.value
    along = {"orders": steps_travelled(target.command.rate, time), "frequencies_hz": time}
    power = float(np.var(residual))
    while along:
        found = {kind: _lines(residual, position) for kind, position in along.items()}
        kind = max(found, key=lambda one: _power(found[one]))
        position, lines = along.pop(kind), found[kind]
        if not lines:
            return
        numbers = tuple(line.frequency_hz for line in lines)
        yield Locked(
            record=target.name, share=min(_power(lines) / power, 1.0), **{kind: numbers[: DIAGNOSIS.lines_named]}
        )
        amplitudes, _ = order_amplitudes(residual[:, None], position, numbers)
        residual = residual - order_signal(amplitudes[:, 0], position, numbers)


def _lines(y: FloatArray, position: FloatArray) -> list[Line]:
    """Return the strongest lines of a series over a position that never falls, in cycles of its unit."""
    moving = np.append(np.diff(position) > 0.0, True)
    even = np.linspace(position[0], position[-1], y.size)
    if not even[-1] > even[0]:
        return []
    found = prominence(np.interp(even, position[moving], y[moving]), 1.0 / (even[1] - even[0]))
    return sorted(spectral_lines(found), key=lambda line: -line.amplitude)[: DIAGNOSIS.lines_removed]


def _power(lines: list[Line]) -> float:
    return sum(0.5 * line.amplitude**2 for line in lines)
