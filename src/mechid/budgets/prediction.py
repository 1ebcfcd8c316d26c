"""Verdicts on emission requirements from the predicted torque, at all rates of a range."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.flying_mechanism import Estimate
from mechid.budgets.line_of_sight import torque_response
from mechid.budgets.operating_mode import MOST_HZ, OperatingMode
from mechid.budgets.predicted_values import TorqueAtRate, predict_values
from mechid.budgets.residual_source import EDGES_HZ
from mechid.budgets.settings import LEVEL
from mechid.budgets.steady_state import SteadyState
from mechid.budgets.torque_draws import draw_torque
from mechid.signal.density import THIRD
from mechid.signal.power import power_density
from mechid.specification.requirement import Requirement, judged_parts
from mechid.specification.settings import SPECIFICATION
from mechid.specification.verdict import Judged, Verdict, combine, judge

BEYOND = 10.0
"""Draws beyond an upper bound, so that its quantile is one."""
MOST_DRAWS = 5000
"""Of the torque at one rate, enough for a confidence of 0.996."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TorqueOverRate:
    """Steady torques of one way of stepping: at each rate of the mode all motions that were found."""

    mode: OperatingMode
    states: tuple[tuple[SteadyState, ...], ...]


@dataclass(frozen=True, kw_only=True)
class PredictedAt:
    """Verdict on the prediction at one rate, full steps/s.

    `outside` where no record of the stepping was near this rate; `follows` where the rotor keeps up with the command.
    """

    stepping: str
    rate: float
    outside: bool
    follows: bool
    judged: Judged


@dataclass(frozen=True, kw_only=True, eq=False)
class Prediction:
    """Verdict on the prediction of one requirement's quantity.

    Attributes
    ----------
    requirement : Requirement
    judged : Judged
        The gravest of all rates and ways of stepping.
    at_rates : tuple of PredictedAt
    judged_hz : (float, float) or None
        Part of the mask that was judged.
    notes : tuple of str
        Why it was not predicted, what was left out or extrapolated.
    """

    requirement: Requirement
    judged: Judged
    at_rates: tuple[PredictedAt, ...] = ()
    judged_hz: tuple[float, float] | None = None
    notes: tuple[str, ...] = ()

    @property
    def verdict(self) -> Verdict:
        """Verdict over all rates and ways of stepping."""
        return self.judged.verdict


def highest_predicted_hz(requirements: Sequence[Requirement], estimate: Estimate) -> float:
    """Return the frequency up to which the torque is predicted for requirements.

    The end of their masks, but neither beyond the records' bandwidth, where nothing is known of what the model lacks,
    nor beyond `MOST_HZ`.
    """
    asked = max((one.mask.range_hz[1] for one in requirements), default=0.0)
    # A third octave about the end of a mask reaches beyond it.
    return float(min(asked * THIRD**0.5, MOST_HZ, _shown_hz(estimate)))


def predict(
    requirements: Sequence[Requirement],
    directions: Sequence[str],
    torques: Sequence[TorqueOverRate],
    estimate: Estimate,
    seed: int = 0,
) -> tuple[Prediction, ...]:
    """Judge the predicted torque against requirements.

    Parameters
    ----------
    requirements : sequence of Requirement
    directions : sequence of str
        Names of the direction that the model predicts, as ``("torque", "mz")``; others are not decidable.
    torques : sequence of TorqueOverRate
    estimate : Estimate
        From which the torques were computed.
    seed : int
        Of the draws.
    """
    found: dict[str, list[PredictedAt]] = {one.name: [] for one in requirements}
    wanted = [one for one in requirements if one.direction in directions]
    rates = [rate for torque in torques for rate in torque.mode.rates.tolist()]
    looks = {one.name: max(sum(one.holds_at(rate) for rate in rates), 1) for one in wanted}
    for torque in torques:
        for rate, states in zip(torque.mode.rates.tolist(), torque.states, strict=True):
            for one in (one for one in wanted if one.holds_at(rate)):
                found[one.name].append(_judge_rate(one, torque.mode, states, estimate, (looks[one.name], seed)))
    return tuple(_prediction(one, directions, torques, estimate, found[one.name]) for one in requirements)


def _prediction(
    one: Requirement,
    directions: Sequence[str],
    torques: Sequence[TorqueOverRate],
    estimate: Estimate,
    at_rates: list[PredictedAt],
) -> Prediction:
    if one.direction not in directions:
        said = (
            f"{one.name}: the model predicts the {directions[0]} alone, not {one.direction}; rates that were not "
            "tested are not decided."
        )
        return Prediction(requirement=one, judged=Judged(verdict=Verdict.NOT_DECIDABLE), notes=(said,))
    if not at_rates:
        said = f"{one.name}: none of its rates is predicted; it is not judged."
        return Prediction(requirement=one, judged=Judged(verdict=Verdict.NOT_DECIDABLE), notes=(said,))
    bands = [_band(torque.mode, estimate) for torque in torques]
    band = (max(low for low, _ in bands), min(high for _, high in bands))
    judged_hz, left = judged_parts(one, band)
    return Prediction(
        requirement=one,
        judged=combine([at.judged for at in at_rates]),
        at_rates=tuple(at_rates),
        judged_hz=judged_hz,
        notes=tuple(_notes(one, at_rates, left)),
    )


def _notes(one: Requirement, at_rates: list[PredictedAt], left: tuple[tuple[float, float], ...]) -> Iterator[str]:
    if left:
        parts = ", ".join(f"{a:.4g} to {b:.4g}" for a, b in left)
        yield (
            f"{one.name}: not predicted is its mask at {parts} Hz, outside the bandwidth of the records or above "
            "highest_hz."
        )
    outside = [at.rate for at in at_rates if at.outside]
    if outside:
        yield (
            f"{one.name}: no record of the stepping ran near {len(outside)} of the rates, {min(outside):.4g} to "
            f"{max(outside):.4g} steps/s: what the model lacks is extrapolated there."
        )
    slipping = [at.rate for at in at_rates if not at.follows]
    if slipping:
        yield (
            f"{one.name}: the rotor does not follow the command at {len(slipping)} of the rates, "
            f"{min(slipping):.4g} to {max(slipping):.4g} steps/s."
        )


def _band(mode: OperatingMode, estimate: Estimate) -> tuple[float, float]:
    """Return the frequencies at which a mode's torque is predicted: the density begins with its lowest band."""
    return float(EDGES_HZ[0]), min(mode.highest_hz, _shown_hz(estimate))


def _shown_hz(estimate: Estimate) -> float:
    """Return the bandwidth of the records: beyond it nothing is known of what the model lacks."""
    if estimate.residual is None:
        return math.inf
    rates = [record.sample_rate_hz for record in estimate.residual.records]
    return max(rates, default=math.inf) / SPECIFICATION.guard


def _judge_rate(
    requirement: Requirement,
    mode: OperatingMode,
    states: tuple[SteadyState, ...],
    estimate: Estimate,
    looks_and_seed: tuple[int, int],
) -> PredictedAt:
    """Return the verdict at one rate: the gravest of the motions that the rotor may have there."""
    looks, seed = looks_and_seed
    upper = 0.5 * (1.0 - requirement.confidence)
    count = int(min(max(BEYOND / upper, LEVEL.samples), MOST_DRAWS))
    source = estimate.residual
    here = None if source is None else source.at(mode.command, states[0].rate)
    verdicts = []
    for state in states:
        drawn = draw_torque(torque_response(state, here), estimate, mode.highest_hz, seed, count, with_hidden=True)
        at = TorqueAtRate(
            draws=drawn,
            rate=state.rate,
            steps=state.steps * max(state.periods, 1),
            rates=here.rates if here is not None else 1,
            random=_random(state),
            alpha=upper,
            looks=looks,
        )
        values = predict_values(at, requirement, _band(mode, estimate))
        verdicts.append(judge(values, requirement, mode.name, state.rate))
    return PredictedAt(
        stepping=mode.name,
        rate=states[0].rate,
        outside=source is not None
        and here is not None
        and (here.outside or not source.has_same_stepping(mode.command)),
        follows=all(state.follows for state in states),
        judged=combine(verdicts),
    )


def _random(state: SteadyState) -> FloatArray:
    """Return frequency and density of what does not repeat of a torque, (k, 2); empty where it is little."""
    if state.unsteady < LEVEL.not_steady:
        return np.zeros((0, 2))
    return np.column_stack(power_density(state.residual, state.sample_rate_hz))
