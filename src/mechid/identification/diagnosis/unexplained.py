"""Residual that nothing explains: whether it goes with motion or time, and effects out of the records' reach."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.command import MeasuredCommand
from mechid.command.edges import steps_travelled
from mechid.identification.diagnosis.candidate import Model
from mechid.identification.diagnosis.settings import DIAGNOSIS
from mechid.identification.effects.scores import COLLINEAR, Landscape, Score
from mechid.identification.effects.selection import is_significant, scores_of_misfit, share_of_misfit
from mechid.identification.effects.settings import IN_DIAGNOSIS as RULES
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
    stepped = [t for t in model.problem.targets if not isinstance(t.command, MeasuredCommand)]
    varying = [t for t in stepped if t.name in model.setting.windows and len(set(t.command.rate.rates)) > 1]
    return tuple(one for target in varying for one in _of(model, target) if one.share >= DIAGNOSIS.least_line_share)


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


NOT_LOOKED_FOR = "not looked for"


def out_of_reach(before: Model, model: Model) -> dict[str, str]:
    """Return the effects that the records could not be asked for, each with why.

    Parameters
    ----------
    before : Model
        The mechanism as written.
    model : Model
        That in which the search has ended.
    """
    plain = (before if math.isfinite(before.cost) else model).landscape()
    weak = _weak(model, plain if model is before else model.landscape()) if model.over_noise > RULES.followed else {}
    return {**weak, **not_carried(plain)}


def weighed(model: Model) -> dict[str, str]:
    """Return every effect looked for beside a model that leaves nothing to explain, each with why it is not named.

    The effect that comes nearest to what is asked for is first.
    """
    landscape = model.landscape()
    scores = sorted(landscape.scores().items(), key=lambda item: item[1].excess, reverse=True)
    whys = {
        name: f"would take {100.0 * share_of_misfit(model, s.share * model.cost):.2g} % of the misfit, chi-square "
        f"{s.chi_square:.3g} for {s.dof}; {_asked_for(s):.3g} is asked for"
        for name, s in scores
    }
    return whys | not_carried(landscape)


def not_carried(landscape: Landscape) -> dict[str, str]:
    """Return the effects that a score says nothing of, each with why."""
    free, unseen = landscape.free.shape[1], "these records do not show it, or not beside what is free already"
    whys = dict.fromkeys(landscape.failed, "the simulation with it fails where the fit has ended")
    for name, J in landscape.effects.items():
        if name in landscape.too_wide:
            whys[name] = (
                f"{J.shape[1]} numbers beside the {free} that are free are as many as the "
                f"{landscape.effective_samples:.3g} independent samples that these records are worth"
            )
        elif not _is_seen(landscape.free, J):
            whys[name] = unseen
    return {name: f"{NOT_LOOKED_FOR}: {why}" for name, why in whys.items()}


def _is_seen(free: FloatArray, further: FloatArray) -> bool:
    """Tell whether derivatives, (m, k), have a direction that those to what is free, (m, n), do not hold."""
    size = np.linalg.norm(free, axis=0)
    U, s, _ = np.linalg.svd(free / np.where(size > 0.0, size, 1.0), full_matrices=False)
    held = U[:, s > COLLINEAR]
    rest = further - held @ (held.T @ further)
    return bool(np.any(np.linalg.norm(rest, axis=0) > COLLINEAR * np.linalg.norm(further, axis=0)))


def _weak(model: Model, landscape: Landscape) -> Mapping[str, str]:
    """Return the effects that would take a share of what is left, which so few samples do not make sure."""
    scores = scores_of_misfit(model, landscape.scores())
    return {
        name: f"would take {100.0 * s.share:.3g} % of the misfit, with a chi-square of {s.chi_square:.3g} only: these "
        f"records are worth {s.effective_samples:.3g} independent samples, and {_asked_for(s):.3g} is asked for"
        for name, s in scores.items()
        if s.share >= RULES.share and not is_significant(s, RULES)
    }


def _asked_for(s: Score) -> float:
    """Return the chi-square from which an effect of a score's freedom counts."""
    return max(RULES.least_chi_square, s.chi_square - s.excess)
