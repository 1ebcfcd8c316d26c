"""Linearisation of a mechanism that holds a position."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from mechid.arrays import FloatArray
from mechid.budgets.flying_mechanism import Estimate
from mechid.command import Command
from mechid.errors import FitError
from mechid.exports.linear.draws import physical_draws
from mechid.exports.linear.state_space import LinearModel, Matrices, Signals, Uncertain
from mechid.kernel.equations import equations_of
from mechid.plant.plant import Plant
from mechid.plant.small_signal import UNITS, SmallSignal, state_units
from mechid.simulation.linearisation import Holding, Linearised, held_inputs, linearise, named_holdings
from mechid.units import SI_UNIT

ACCELERATION = "output_acceleration"
"""Relative acceleration of the output, needed for coupling to a structure."""
RATES = ("output_rate", "rotor_rate")
"""Rates whose derivative is this acceleration; the first one that the mechanism has is used."""


@dataclass(frozen=True, eq=False)
class HeldMechanism:
    """Mechanism that holds a position.

    Attributes
    ----------
    opened : SmallSignal
    command : Command
        Command whose start angle is held.
    uncertain : Uncertain
    """

    opened: SmallSignal
    command: Command
    uncertain: Uncertain

    @property
    def plant(self) -> Plant:
        """The plant of the mechanism."""
        return self.opened.mechanism.plant

    @cached_property
    def inputs(self) -> FloatArray:
        """Held values of all inputs of the plant."""
        return held_inputs(self.plant, self.command)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Parameters with derivatives: all except structural and tied ones."""
        declared, parameters = self.plant.declarations, self.opened.mechanism.parameters
        return tuple(n for n, d in declared.items() if not d.structural and not parameters[n].tied_to)

    def models(self, count: int, seed: int) -> dict[str, LinearModel]:
        """Return the model of each holding condition, with `count` draws.

        Raises
        ------
        FitError
            There is no equilibrium within reach, or too few draws are physical.
        """
        draws = physical_draws(self.opened.mechanism, self.uncertain, count, seed)
        return {name: self._model(name, draws) for name in self.holdings}

    @cached_property
    def holdings(self) -> dict[str, Holding]:
        """Holding conditions of friction, by name."""
        return named_holdings(self.plant)

    def about(self, name: str, changed: Mapping[str, float] | None = None) -> Linearised:
        """Linearise the plant in a holding condition, optionally with changed values of the mechanism file."""
        p, command = self.opened.mechanism.kernel_values(changed), self.command
        try:
            return _settle_filter(linearise(self.plant, p, self.inputs, command.start_angle_rad, self.holdings[name]))
        except FitError as error:
            raise FitError(
                f"the mechanism has no rest near {command.start_angle_deg:g} electrical degrees; hold another angle, "
                "--option start_angle_deg=DEG"
            ) from error

    def moving_states(self, name: str) -> list[int]:
        """Return the indices of the states that can move: not those held by friction or driven only by held ones."""
        about = self.about(name)
        return _movable_states(self._whole(Matrices(*about.matrices)), self._whole(self._by_parameter(about)))

    def matrices_at(self, name: str, changed: Mapping[str, float], kept: Sequence[int]) -> Matrices:
        """Return the matrices of some states at changed parameters, with the equilibrium recomputed."""
        return _select_states(self._whole(Matrices(*self.about(name, changed).matrices)), kept)

    def rest(self, about: Linearised) -> tuple[list[float], list[float]]:
        """Return modes and kernel parameters, the further arguments of the nonlinear equations."""
        return [about.holding[s] for s in equations_of(self.plant).rates.arguments[2]], about.p.tolist()

    def outputs_at(self, x: FloatArray, inputs: Sequence[float], rest: tuple[Sequence[float], ...]) -> FloatArray:
        """Return the outputs by the nonlinear equations, (n_y,); `rest` are modes and kernel parameters."""
        equations = equations_of(self.plant)
        y = equations.outputs(x.tolist(), inputs, *rest)
        accelerated = equations.rates(x.tolist(), inputs, *rest)[self._acceleration_index]
        return np.concatenate([y, accelerated])

    def _model(self, name: str, draws: FloatArray) -> LinearModel:
        about, kept = self.about(name), self.moving_states(name)
        whole, slopes = self._whole(Matrices(*about.matrices)), self._whole(self._by_parameter(about))
        drawn = [dict(zip(self.uncertain.names, draw.tolist(), strict=True)) for draw in draws]
        samples = [self.matrices_at(name, values, kept) for values in drawn]
        states = self._states()
        outputs = [(q, SI_UNIT[q]) for q in self.plant.outputs] + [(ACCELERATION, "rad/s2")] * len(
            self._acceleration_index
        )
        return LinearModel(
            name=name,
            states=Signals(*zip(*(states[k] for k in kept), strict=True)) if kept else Signals((), ()),
            inputs=Signals(self.opened.inputs, tuple(UNITS[i] for i in self.opened.inputs)),
            outputs=Signals(*zip(*outputs, strict=True)),
            matrices=_select_states(whole, kept),
            x=about.x[kept],
            y=self.outputs_at(about.x, about.inputs.tolist(), self.rest(about)),
            names=self.names,
            by_parameter=_select_states(slopes, kept),
            uncertain=self.uncertain,
            limits=self._limits(about),
            margins=about.margins(),
            samples=_stack(samples, _select_states(whole, kept)),
            draws=draws,
        )

    def _by_parameter(self, about: Linearised) -> Matrices:
        """Return the derivatives with respect to `names`, in the units of the file."""
        jacobian = self.opened.mechanism.kernel_jacobian()
        moved = np.array([jacobian[name] for name in self.names])
        return Matrices(*(np.tensordot(moved, slope, axes=1) for slope in about.by_parameter))

    @cached_property
    def _acceleration_index(self) -> list[int]:
        """Index of the state whose derivative is the acceleration of the output, if there is one."""
        rates = [self.plant.offered[q] for q in RATES if q in self.plant.offered]
        return [k for k, state in enumerate(self.plant.states) if state in rates[:1]]

    @cached_property
    def columns(self) -> list[int]:
        """Indices of the external inputs among those of the plant."""
        return [[s.name for s in self.plant.inputs].index(name) for name in self.opened.inputs]

    def _whole(self, of: Matrices) -> Matrices:
        """Restrict matrices to the external inputs, and add the acceleration of the output."""
        A, B, rows = of.A, of.B[..., self.columns], self._acceleration_index
        C = np.concatenate([of.C, A[..., rows, :]], axis=-2)
        D = np.concatenate([of.D[..., self.columns], B[..., rows, :]], axis=-2)
        # Adding 0.0 turns -0.0 into 0.0, for clean files.
        return Matrices(*(matrix + 0.0 for matrix in (A, B, C, D)))

    def _states(self) -> list[tuple[str, str]]:
        """Return name and unit of each state, those of a quantity if the state is one."""
        units = state_units(self.plant)
        # A state that is a measured quantity takes its name and unit.
        quantities = {expr: q for q, expr in self.plant.offered.items() if q in SI_UNIT}
        return [
            (quantities[s], SI_UNIT[quantities[s]]) if s in quantities else (str(s), units.get(str(s), ""))
            for s in (*self.plant.states, *self.plant.filter.states)
        ]

    def _limits(self, about: Linearised) -> dict[str, tuple[float, float]]:
        """Return the limits of the deviation of each phase input."""
        peak = self.opened.peak
        held = {name: about.evaluate(term) for name, term in self.opened.driven.items() if name in peak}
        return {name: (-peak[name] - value, peak[name] - value) for name, value in held.items()}


def _settle_filter(about: Linearised) -> Linearised:
    """Move the filter states of a linearisation to their equilibrium; only outputs at rest change, not the matrices."""
    n = len(about.plant.states)
    if not about.plant.filter.states:
        return about
    modes = [about.holding[s] for s in equations_of(about.plant).rates.arguments[2]]
    fed = equations_of(about.plant).rates(about.x.tolist(), about.inputs.tolist(), modes, about.p.tolist())[n:]
    x = about.x.copy()
    x[n:] -= np.linalg.solve(about.matrices[0][n:, n:], fed)
    return replace(about, x=x)


def uncertain_of(estimate: Estimate) -> Uncertain:
    """Return the parameters of an estimate with their covariance."""
    declared = estimate.mechanism.plant.declarations
    values = np.array([estimate.mechanism.value(name) for name in estimate.names], dtype=np.float64)
    units = tuple(declared[name].unit for name in estimate.names)
    return Uncertain(estimate.names, units, values, estimate.covariance)


def _movable_states(whole: Matrices, slopes: Matrices) -> list[int]:
    """Return the states that can move, from the couplings in the matrices and their derivatives."""
    moves = np.abs(np.concatenate([whole.A, whole.B], axis=1)) + np.abs(
        np.concatenate([slopes.A, slopes.B], axis=2)
    ).sum(axis=0)
    kept, n = list(range(len(whole.A))), len(whole.A)
    # Removing a held state can isolate others, so the reduction is repeated until nothing changes.
    while True:
        columns = [*kept, *range(n, moves.shape[1])]
        left = [k for k in kept if moves[k, columns].any()]
        if left == kept:
            return kept
        kept = left


def _select_states(of: Matrices, states: Sequence[int]) -> Matrices:
    A = of.A[..., states, :][..., states]
    return Matrices(A, of.B[..., states, :], of.C[..., states], of.D)


def _stack(samples: list[Matrices], like: Matrices) -> Matrices:
    """Stack matrices along a new first axis, (N, ...)."""
    if not samples:
        return Matrices(*(np.zeros((0, *matrix.shape)) for matrix in like.all))
    return Matrices(*(np.array(each) for each in zip(*(s.all for s in samples), strict=True)))
