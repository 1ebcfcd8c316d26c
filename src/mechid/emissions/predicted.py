"""Emission predicted by a fit, at all rates and ways of stepping of a range."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mechid.analysis.residual_file import FILE_NAME as RESIDUAL_NAME
from mechid.arrays import BoolArray, FloatArray
from mechid.budgets.attractors import steady_states
from mechid.budgets.emission import emission
from mechid.budgets.flight_entry import Flight, read_flight
from mechid.budgets.flying_mechanism import Estimate, flying_estimate
from mechid.budgets.line_of_sight import torque_response
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.prediction import Prediction, TorqueOverRate, highest_predicted_hz, predict
from mechid.campaign.place import Place
from mechid.campaign.toml_file import read_toml
from mechid.command import Command
from mechid.emissions.emission_line import EmissionLine
from mechid.errors import InputFileError, UsageError
from mechid.exports.handover import Trial
from mechid.exports.stepping import Stepping, choose_rates, steppings
from mechid.fits.load import load_fit
from mechid.identification.result.fit import Fit
from mechid.identification.result.fit_file import estimate_path, read_fit
from mechid.records import Mounting
from mechid.records.components import TORQUE
from mechid.specification.requirement import Requirement, direction_of
from mechid.specification.verdict import Judged, Verdict

SEED = 0
SHOWN_ORDERS = 4
"""Orders of a figure: those with the largest lines."""
BENCH, FLIGHT = "bench", "flight"


@dataclass(frozen=True, kw_only=True, eq=False)
class OrderCurve:
    """One order of the torque over the rate: predicted line with its 95 % bound, and the measured lines.

    Attributes
    ----------
    stepping : str
    order : float
        Of the step rate.
    rates : (r,)
        Full steps/s.
    amplitude, bound : (r,)
        Peak values in N m; NaN where the model has no line at this order.
    measured : (m, 3)
        Rate, amplitude and its standard error.
    """

    stepping: str
    order: float
    rates: FloatArray
    amplitude: FloatArray
    bound: FloatArray
    measured: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class PredictedEmission:
    """Predictions of all requirements by one fit.

    Attributes
    ----------
    predictions : tuple of Prediction
        One for each requirement.
    curves : tuple of OrderCurve
        The largest orders of each way of stepping.
    place : str
        `BENCH`: the torque at the transducer with the values of the bench; `FLIGHT`: that on the base in flight.
    source : str
        The fit.
    digest : str
        SHA-256 of the fitted mechanism's file; empty if it has none.
    rates : mapping of str to (float, float, int, int)
        By way of stepping the least and the largest rate in full steps/s, their number, and how many were tested.
    highest_hz : float
    notes : tuple of str
    """

    predictions: tuple[Prediction, ...]
    curves: tuple[OrderCurve, ...]
    place: str
    source: str
    digest: str
    rates: dict[str, tuple[float, float, int, int]]
    highest_hz: float
    notes: tuple[str, ...]


def decide(measured: Judged, predicted: Judged, place: str) -> Judged:
    """Return the verdict on records and prediction together.

    On the bench a measured fail stands, and so does a measured value above its limit that is not shown to be one. The
    prediction decides otherwise: it knows the rates that were not tested and lines below the background. In flight it
    decides alone, since the records are of other values.
    """
    if place == FLIGHT or measured.verdict is Verdict.NOT_DECIDABLE:
        return predicted
    worst = measured.worst
    is_above = measured.verdict is Verdict.NOT_SHOWN and worst is not None and worst.value > worst.limit
    if measured.verdict is Verdict.FAIL or (is_above and predicted.verdict is Verdict.PASS):
        return measured
    return predicted


def estimate_for(fit: Fit | Path | str, flight: Path | str | None) -> Estimate:
    """Return the estimate of a fit: at the transducer with the bench's values, or on the base in flight.

    Parameters
    ----------
    fit : Fit or Path
        A fit in memory that holds its campaign, or a result folder.
    flight : Path or None
        File with a ``[flight]`` table, as BUDGET.toml.

    Raises
    ------
    InputFileError
        The fit or the file is missing or wrong, or the mechanism cannot be driven by steps alone.
    """
    found = fit if isinstance(fit, Fit) else _read(Path(fit))
    if flight is None:
        return flying_estimate(found, Flight(), stand=True)
    path = Path(flight)
    table = read_toml(path)
    if "flight" not in table:
        raise InputFileError(f"{path.name}: no [flight] table; write what differs in flight, or an empty [flight]")
    return flying_estimate(found, read_flight(table["flight"], Place(path.name).key("flight")))


def _read(place: Path) -> Fit:
    """Return the fit of a folder; its campaign is read only where the residuals have to be computed from it."""
    if not place.exists():
        raise InputFileError(f"{place}: there is no such folder; give the result folder of mechid identify")
    path = estimate_path(place)
    return read_fit(path) if (path.parent / RESIDUAL_NAME).is_file() else load_fit(place)


def predict_emission(
    estimate: Estimate,
    requirements: Sequence[Requirement],
    trials: Sequence[Trial],
    lines: Sequence[EmissionLine],
    mounting: Mounting | None,
    *,
    place: str,
    source: str,
) -> PredictedEmission:
    """Predict the torque over the range of the records and of the requirements, and judge it.

    Parameters
    ----------
    estimate : Estimate
    requirements : sequence of Requirement
    trials : sequence of Trial
        Step-driven records.
    lines : sequence of EmissionLine
        Measured lines, for comparison.
    mounting : Mounting or None
    place : str
        `BENCH` or `FLIGHT`.
    source : str
        Of the fit, for the reader.

    Raises
    ------
    UsageError
        No record is driven by steps.
    FitError
        The mechanism diverged.
    """
    ways = steppings(trials)
    if not ways:
        raise UsageError("--fit: no record of the campaign is driven by steps; a prediction needs their stepping")
    drive = direction_of(TORQUE, mounting) or TORQUE
    directions = tuple(dict.fromkeys((TORQUE, drive)))
    wanted = [one for one in requirements if one.direction in directions]
    highest_hz = highest_predicted_hz(wanted, estimate)
    torques: tuple[TorqueOverRate, ...] = ()
    if wanted:
        asked = [ends for one in wanted for ends in one.rates]
        rates = choose_rates(estimate.mechanism, ways, asked)
        torques = tuple(_torque(estimate, way, rates, highest_hz) for way in ways)
    return PredictedEmission(
        predictions=predict(requirements, directions, torques, estimate, SEED),
        curves=tuple(_curves(estimate, torques, trials, [one for one in lines if one.direction == drive])),
        place=place,
        source=source,
        digest=estimate.digest,
        rates={way.name: _counts(torque.mode.rates, way) for way, torque in zip(ways, torques, strict=False)},
        highest_hz=highest_hz,
        notes=tuple(_notes(estimate)),
    )


def _torque(estimate: Estimate, way: Stepping, rates: FloatArray, highest_hz: float) -> TorqueOverRate:
    mode = OperatingMode(name=way.name, command=way.command, rates=rates, highest_hz=highest_hz)
    return TorqueOverRate(mode=mode, states=steady_states(estimate.mechanism, mode, estimate.names, 1))


def _counts(rates: FloatArray, way: Stepping) -> tuple[float, float, int, int]:
    tested: BoolArray = way.covers(rates)
    return float(rates[0]), float(rates[-1]), int(rates.size), int(np.sum(tested))


def _notes(estimate: Estimate) -> Iterator[str]:
    if estimate.outcome:
        yield f"The fit is not reliable: {estimate.outcome}"
    if estimate.residual is None:
        yield (
            f"The fit has no {RESIDUAL_NAME}, so that the bounds hold no torque that the model lacks: mechid report "
            "makes it anew from records of the torque."
        )


def _curves(
    estimate: Estimate, torques: Sequence[TorqueOverRate], trials: Sequence[Trial], lines: Sequence[EmissionLine]
) -> Iterator[OrderCurve]:
    """Yield the orders with the largest lines of each way of stepping, at each rate of the largest motion."""
    for torque in torques:
        mode = torque.mode
        own = {trial.name for trial in trials if _steps_alike(trial.command, mode.command)}
        found = []
        for rate, states in zip(mode.rates.tolist(), torque.states, strict=True):
            here = None if estimate.residual is None else estimate.residual.at(mode.command, rate)
            largest = max(states, key=lambda state: state.rms)
            found.append(emission(torque_response(largest, here), estimate, mode.highest_hz, SEED))
        sizes: dict[float, float] = {}
        for at in found:
            for order, size in zip(at.orders.tolist(), np.abs(at.modelled).tolist(), strict=True):
                sizes[order] = max(sizes.get(order, 0.0), size)
        for order in sorted(sizes, key=lambda one: -sizes[one])[:SHOWN_ORDERS]:
            points = [(one.rate, one.amplitude, one.sigma) for one in lines if one.record in own and one.order == order]
            yield OrderCurve(
                stepping=mode.name,
                order=order,
                rates=mode.rates,
                amplitude=np.array([_at_order(order, at.orders, np.abs(at.modelled)) for at in found]),
                bound=np.array([_at_order(order, at.orders, at.bound) for at in found]),
                measured=np.array(points, dtype=np.float64).reshape(-1, 3),
            )


def _steps_alike(command: Command, other: Command) -> bool:
    return (command.stepping, command.microsteps, command.table) == (other.stepping, other.microsteps, other.table)


def _at_order(order: float, orders: FloatArray, values: FloatArray) -> float:
    here = np.flatnonzero(orders == order)
    return float(values[here[0]]) if here.size else np.nan
