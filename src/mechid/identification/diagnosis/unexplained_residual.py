"""Description of an unexplained residual: its lines over position or time, and effects that cannot be tested."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.command import MeasuredCommand
from mechid.command.edges import steps_travelled
from mechid.identification.diagnosis.candidate import CandidateModel
from mechid.identification.diagnosis.settings import DIAGNOSIS
from mechid.identification.effects.scores import COLLINEAR, Landscape, Score
from mechid.identification.effects.selection import is_significant, scores_of_misfit, share_of_misfit
from mechid.identification.effects.settings import IN_DIAGNOSIS as RULES
from mechid.identification.output_error.misfit import misfit_series
from mechid.identification.output_error.target import Target
from mechid.signal.lines import Line, prominence, spectral_lines
from mechid.signal.orders import order_amplitudes, order_signal


@dataclass(frozen=True, kw_only=True)
class LockedLines:
    """Lines of a residual over position or over time.

    Attributes
    ----------
    record : str
    orders : tuple of float
        Multiples of the full-step rate, the strongest first; empty for lines over time.
    frequencies_hz : tuple of float
        Frequencies, the strongest first; empty for lines over position.
    share : float
        Share of the residual's power in these lines.
    """

    record: str
    orders: tuple[float, ...] = ()
    frequencies_hz: tuple[float, ...] = ()
    share: float

    @property
    def words(self) -> str:
        """Description in a sentence."""
        if self.orders:
            numbers = ", ".join(f"{order:.4g}" for order in self.orders)
            place = f"follows the motor's motion, at {numbers} times the full-step rate"
        else:
            place = f"is at {', '.join(f'{hz:.4g}' for hz in self.frequencies_hz)} Hz at any rate"
        return f"Of the residual of record {self.record}, {100.0 * self.share:.0f} % {place}."


def locked_lines(model: CandidateModel) -> tuple[LockedLines, ...]:
    """Return the lines of the residuals of all records with a varying rate, at a model's optimum."""
    # At a constant rate, position and time are proportional: only a varying rate separates them.
    stepped = [t for t in model.problem.targets if not isinstance(t.command, MeasuredCommand)]
    varying = [t for t in stepped if t.name in model.setting.windows and len(set(t.command.rate.rates)) > 1]
    return tuple(
        one
        for target in varying
        for one in _lines_of_residual(model, target)
        if one.share >= DIAGNOSIS.least_line_share
    )


def _lines_of_residual(model: CandidateModel, target: Target) -> Iterator[LockedLines]:
    """Yield the stronger lines of a residual, over position or time, and then the other lines of the rest."""
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
        yield LockedLines(
            record=target.name, share=min(_power(lines) / power, 1.0), **{kind: numbers[: DIAGNOSIS.lines_named]}
        )
        # The stronger lines are removed, so that they do not leak into the spectrum over the other position.
        amplitudes, _ = order_amplitudes(residual[:, None], position, numbers)
        residual = residual - order_signal(amplitudes[:, 0], position, numbers)


def _lines(y: FloatArray, position: FloatArray) -> list[Line]:
    """Return the strongest lines of a series over a position that never decreases, in cycles per unit of position."""
    # Interpolation needs increasing positions, and a spectrum an even grid: samples at rest are left out.
    moving = np.append(np.diff(position) > 0.0, True)
    even = np.linspace(position[0], position[-1], y.size)
    if not even[-1] > even[0]:
        return []
    found = prominence(np.interp(even, position[moving], y[moving]), 1.0 / (even[1] - even[0]))
    return sorted(spectral_lines(found), key=lambda line: -line.amplitude)[: DIAGNOSIS.lines_removed]


def _power(lines: list[Line]) -> float:
    return sum(0.5 * line.amplitude**2 for line in lines)


NOT_LOOKED_FOR = "not looked for"


def explain_untested(before: CandidateModel, model: CandidateModel) -> dict[str, str]:
    """Return the effects that these records cannot test, each with the reason.

    Parameters
    ----------
    before : CandidateModel
        The mechanism as written.
    model : CandidateModel
        Final model of the search.
    """
    plain = (before if math.isfinite(before.cost) else model).landscape
    weak = (
        _insignificant_effects(model, plain if model is before else model.landscape)
        if model.over_noise > RULES.noise_limit
        else {}
    )
    return {**weak, **untestable_effects(plain)}


def explain_omissions(model: CandidateModel) -> dict[str, str]:
    """Return every candidate effect of a model that leaves no misfit, each with the reason why it is not reported.

    The effect that comes nearest to its threshold is first.
    """
    landscape = model.landscape
    scores = sorted(landscape.scores().items(), key=lambda item: item[1].excess, reverse=True)
    whys = {
        name: f"would explain {100.0 * share_of_misfit(model, s.share * model.cost):.2g} % of the misfit, chi-square "
        f"{s.chi_square:.3g} for {s.dof}; {_required_chi_square(s):.3g} is required"
        for name, s in scores
    }
    return whys | untestable_effects(landscape)


def untestable_effects(landscape: Landscape) -> dict[str, str]:
    """Return the effects for which there is no score, each with the reason."""
    free, unseen = landscape.free.shape[1], "these records do not show it, or not separately from the free parameters"
    whys = dict.fromkeys(landscape.failed, "the simulation with it fails where the fit has ended")
    for name, J in landscape.effects.items():
        if name in landscape.too_wide:
            whys[name] = (
                f"its {J.shape[1]} parameters and the {free} free ones are as many as the "
                f"{landscape.effective_samples:.3g} effective samples of these records"
            )
        elif not _is_separable(landscape.free, J):
            whys[name] = unseen
    return {name: f"{NOT_LOOKED_FOR}: {why}" for name, why in whys.items()}


def _is_separable(free: FloatArray, further: FloatArray) -> bool:
    """Tell whether derivatives, (m, k), have a direction outside the span of those by the free parameters, (m, n)."""
    size = np.linalg.norm(free, axis=0)
    # An orthonormal basis of the free directions; the part of the others outside it is the visible one.
    U, s, _ = np.linalg.svd(free / np.where(size > 0.0, size, 1.0), full_matrices=False)
    held = U[:, s > COLLINEAR]
    rest = further - held @ (held.T @ further)
    return bool(np.any(np.linalg.norm(rest, axis=0) > COLLINEAR * np.linalg.norm(further, axis=0)))


def _insignificant_effects(model: CandidateModel, landscape: Landscape) -> Mapping[str, str]:
    """Return the effects that would explain a share of the misfit but are not significant with so few samples."""
    scores = scores_of_misfit(model, landscape.scores())
    return {
        name: f"would explain {100.0 * s.share:.3g} % of the misfit, but with a chi-square of {s.chi_square:.3g} only: "
        f"with {s.effective_samples:.3g} effective samples in these records, {_required_chi_square(s):.3g} is required"
        for name, s in scores.items()
        if s.share >= RULES.share and not is_significant(s, RULES)
    }


def _required_chi_square(s: Score) -> float:
    """Return the chi-square required of an effect with as many degrees of freedom as a score has."""
    return max(RULES.least_chi_square, s.chi_square - s.excess)
