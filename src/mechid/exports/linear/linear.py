"""Linear models of a fit at holding, harmonic forcing at steady rates, and remarks for the user."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from mechid.budgets.flying_mechanism import Estimate
from mechid.campaign import Campaign
from mechid.command import Command, RateProfile
from mechid.errors import InputFileError, UsageError
from mechid.exports.forcing import Forcing, estimate_on_base, forcing
from mechid.exports.handover import Handover, handover
from mechid.exports.linear.forcing import KEPT, OrderForcing, sort_by_orders
from mechid.exports.linear.fraction import fraction
from mechid.exports.linear.linearisation import HeldMechanism, uncertain_of
from mechid.exports.linear.loops.loop_file import read_loop_file
from mechid.exports.linear.loops.loops import DRAWS, Loops, close_loops
from mechid.exports.linear.options import Options
from mechid.exports.linear.state_space import LinearModel, Uncertain
from mechid.exports.option_texts import refuse_values
from mechid.exports.stepping import choose_rates, steppings
from mechid.identification.result.fit import Fit
from mechid.parameter import Role
from mechid.plant.flight import flying_plant, keeps_stand
from mechid.plant.small_signal import small_signal

FORMAT = "mechid-linear/1"
RESTING = Command(stepping="full", microsteps=1, rate=RateProfile.constant(0.0))
HOLDS: Mapping[str, str] = {
    "stuck": "friction holds the rotor",
    "locked": "friction holds rotor and load",
    "free": "friction is taken away",
    "holding": "its friction is linear at rest",
}
"""State of friction in each model, in words."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Linear:
    """Linear models of a mechanism, and its torque at steady rates.

    Attributes
    ----------
    name : str
    held : HeldMechanism
        The mechanism, and the command whose start angle it holds.
    uncertain : Uncertain
        Parameters with a covariance.
    models : mapping of str to LinearModel
        Models by the state of friction, as ``linear["free"]``.
    forcing : tuple of OrderForcing
        One for each stepping mode of the campaign.
    words : tuple of str
        Remarks for the user, one sentence each.
    provenance : mapping
    loops : Loops or None
        Loops of the drive electronics, if gains were given.
    """

    name: str
    held: HeldMechanism
    uncertain: Uncertain
    models: Mapping[str, LinearModel]
    forcing: tuple[OrderForcing, ...]
    words: tuple[str, ...]
    provenance: Mapping[str, Any]
    loops: Loops | None = None

    def __getitem__(self, name: str) -> LinearModel:
        """Return the model of a holding condition."""
        return self.models[name]

    def to_dict(self) -> dict[str, Any]:
        """Return the content of linear.json."""
        draws = next((model.draws for model in self.models.values()), np.zeros((0, 0)))
        return {
            "format": FORMAT,
            "name": self.name,
            "words": list(self.words),
            "provenance": dict(self.provenance),
            "start_angle_deg": self.held.command.start_angle_deg,
            "uncertain": self.uncertain.to_dict(),
            "draws": draws.tolist(),
            "models": {n: {**m.to_dict(), "fraction": fraction(m).to_dict()} for n, m in self.models.items()},
            "forcing": [one.to_dict() for one in self.forcing],
            **({"loops": self.loops.to_dict()} if self.loops else {}),
        }


def linear_of(source: Handover, options: Options | None = None) -> Linear:
    """Compute the linear models of a handover, at the start of its first record, and its torque at steady rates.

    Raises
    ------
    InputFileError
        No step command drives the mechanism, a changed value is impossible, or a loop of the electronics is unstable.
    UsageError
        A changed parameter is unknown, or its value is impossible.
    FitError
        There is no equilibrium within reach, too few draws from the covariance are physical, or the mechanism diverges
        at a steady rate.
    """
    options = options or Options()
    _refuse(source, options)
    estimate = estimate_on_base(source, options.values, stand=options.stand)
    held = HeldMechanism(small_signal(estimate.mechanism), _command(source, options), uncertain_of(estimate))
    models = _models(held, options)
    loops = close_loops(held, models, options.loop, DRAWS, options.seed) if options.loop else None
    every = tuple(sort_by_orders(one, estimate) for one in _forcings(source, options, estimate))
    return Linear(
        name=source.name,
        held=held,
        uncertain=held.uncertain,
        models=models,
        forcing=every,
        words=(*_words(held, models, every, estimate, options), *(loops.words if loops else ())),
        provenance=source.provenance,
        loops=loops,
    )


def _models(held: HeldMechanism, options: Options) -> dict[str, LinearModel]:
    try:
        # NumPy warns of a division by 0 by default; here it is an error of the given values.
        with np.errstate(divide="raise", invalid="raise"):
            return held.models(options.samples, options.seed)
    except ArithmeticError as error:
        raise UsageError(
            "values: with them the equations divide by 0, as with an inertia of 0; write values above 0"
        ) from error


def linear_of_fit(fit: Fit, campaign: Campaign | None, anyway: bool, **options: Any) -> Linear:
    """Compute the linear models of a fit; `options` are those of `Options`, as in `Fit.linear`.

    Raises
    ------
    FitError
        The fit has failed; or as `linear_of`.
    UsageError
        An option is invalid.
    InputFileError
        As `linear_of`.
    """
    loop = options.pop("loop", None)
    design = read_loop_file(loop) if isinstance(loop, str | Path) else loop
    return linear_of(handover(fit, campaign, anyway=anyway), Options(**options, loop=design))


def _command(source: Handover, options: Options) -> Command:
    """Return the command whose start angle is held."""
    command = source.trials[0].command if source.trials else RESTING
    angle = command.start_angle_deg if options.start_angle_deg is None else options.start_angle_deg
    return replace(command, start_angle_deg=angle)


def _refuse(source: Handover, options: Options) -> None:
    """Refuse mechanisms without such a linear model, and values of unknown parameters."""
    plant = flying_plant(source.mechanism, stand=options.stand)
    refuse_values(options.values, plant)
    for name in plant.names_with_role(Role.SUPPLY):
        if name not in source.mechanism.parameters and name not in options.values:
            raise InputFileError(
                f"{name}: on the bench measured channels drove the motor, and a linear model holds what a command "
                f"drives; give --option {name}=VALUE"
            )


def _forcings(source: Handover, options: Options, estimate: Estimate) -> Iterator[Forcing]:
    """Yield the forcing of each stepping mode of the records."""
    modes, rates = steppings(source.trials), options.rates
    if modes and rates != ():
        wanted = choose_rates(estimate.mechanism, modes) if rates is None else np.unique(rates)
        yield from (forcing(estimate, mode, wanted) for mode in modes)


def _words(
    held: HeldMechanism,
    models: Mapping[str, LinearModel],
    every: tuple[OrderForcing, ...],
    estimate: Estimate,
    options: Options,
) -> Iterator[str]:
    angle = f"{held.command.start_angle_deg:g} electrical degrees"
    stands = keeps_stand(estimate.mechanism)
    where = "on its bench: torque is what the transducer shows" if stands else _in_flight(estimate.left)
    yield f"Linear for small deviations about the rest where the motor holds {angle}, {where}."
    if options.values:
        given = ", ".join(f"{name} = {value:g}" for name, value in options.values.items())
        yield f"{'On its bench' if stands else 'In flight'} {given}."
    for name, model in models.items():
        until = "".join(f", until [{table}] has {m:.3g} N m more to hold" for table, m in model.margins.items())
        yield f'"{name}": {HOLDS[name]}{until}.'
    units = dict(zip(held.opened.inputs, next(iter(models.values())).inputs.units, strict=True))
    for i, (low, high) in next(iter(models.values())).limits.items():
        yield f"The supply lets {i} go from {low:.4g} to {high:.4g} {units[i]}."
    yield from held.opened.objections
    if every:
        yield (
            f"Forcing for {', '.join(one.name for one in every)} at {every[0].rates.size} rates from "
            f"{every[0].rates[0]:.4g} to {every[0].rates[-1]:.4g} full steps/s; orders below {100.0 * KEPT:g} % of the "
            "largest line at all rates are left out."
        )
    else:
        yield "No forcing: no rates, or no campaign with a record that steps the motor, were given."


def _in_flight(left: Mapping[str, str]) -> str:
    tables = [name for name in left if name.startswith("[")]
    listed = f" ({', '.join(tables)})" if tables else ""
    return f"in flight: without what stays on the bench{listed}"
