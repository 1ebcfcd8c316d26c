"""Slow reference twin of the generated kernel: the same plant integrated by SciPy's DOP853, written for clarity.

Terms are substituted, filter states are ordinary states, and every function is lambdified. The
twin integrates from edge to edge and searches each step for the first guard that reaches zero. For
sensitivities it integrates the variational equations S' = f_s S + f_p along with the state.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import DOP853, DenseOutput

from mechid.arrays import FloatArray
from mechid.command import Excitation
from mechid.kernel.crossing import first_zero
from mechid.kernel.equations import Equations, equations_of
from mechid.plant.plant import Plant

THROWN = 1e-9
"""A margin this far below zero, relative to its change over a sample interval, got there by a jump, not by the flow."""
ABSOLUTE = 1e-2
"""Absolute over relative tolerance: the gear's angle is about 1e-3 rad and is multiplied by K_s = 1e3 N m/rad."""

Fired = tuple[int, int]
"""Switch and guard (in the order of its mode's guards) that reached zero."""


@dataclass(frozen=True, kw_only=True)
class TwinState:
    """State of a run.

    Attributes
    ----------
    time : float
        Command time in s.
    s : (n,) array
        States of the plant, then of its filter, SI units.
    S : (n, m) array
        Derivatives of `s` with respect to the sensitive parameters.
    inputs : (i,) array
        Inputs of the excitation.
    modes : tuple of int
        Mode of each switch.
    armed : tuple of tuple of bool
        For each guard of those modes, whether it has been above zero since the mode began.
    """

    time: float
    s: FloatArray
    S: FloatArray
    inputs: FloatArray
    modes: tuple[int, ...]
    armed: tuple[tuple[bool, ...], ...]


@dataclass(frozen=True, kw_only=True)
class TwinSwitch:
    """One switch: its instant in s and that instant's derivatives (m,), modes before and after."""

    time: float
    switch: int
    before: int
    after: int
    sensitivity: FloatArray


@dataclass(frozen=True, kw_only=True)
class TwinRun:
    """Result of a run: y (n, n_y), jacobian (n, n_y, m), the switches, and the final state.

    `rate` = dy/dt (n, n_y) is filled only if there are sensitive parameters.
    """

    y: FloatArray
    rate: FloatArray
    jacobian: FloatArray
    switching: tuple[TwinSwitch, ...]
    end: TwinState


def simulate_twin(
    plant: Plant,
    excitation: Excitation,
    times: ArrayLike,
    p: ArrayLike,
    *,
    start_angle_rad: float = 0.0,
    begin: TwinState | None = None,
    sensitive: Sequence[int] = (),
    tolerance: float = 1e-10,
) -> TwinRun:
    """Simulate a plant at uniform sample instants.

    If an output jumps within a sample interval, the jump enters that sample with its mean over the interval.

    Parameters
    ----------
    plant : Plant
    excitation : Excitation
    times : (n,) array
        At least two sample instants, s of command time; before 0 the mechanism rests.
    p : (n_p,) array
        The kernel's parameters.
    start_angle_rad : float
        Electrical angle theta_0 at the start of the record.
    begin : TwinState, optional
        Initial state instead of the start, at or before the first sample.
    sensitive : sequence of int
        Indices of the parameters to differentiate with respect to.
    tolerance : float
        Relative tolerance of one step of the integrator.
    """
    twin = Twin(equations_of(plant), np.asarray(p, dtype=np.float64), tuple(sensitive), tolerance)
    state = begin or twin.start(excitation.initial, start_angle_rad)
    samples = _Samples(twin, np.asarray(times, dtype=np.float64), state.time)
    switching: list[TwinSwitch] = []
    for inputs, end in _stretches(excitation, state, float(samples.times[-1])):
        state, fixed = replace(state, inputs=inputs), np.zeros(len(sensitive))
        while True:
            thrown = fired = twin.guard_below_zero(state, samples.interval)
            if fired is None:
                state, fired = twin.arc(state, end, samples)
            if fired is None:
                break
            before, (state, switch) = state, twin.fire_guard(state, *fired, fixed if thrown else None)
            samples.jump(before, state, switch)
            switching.append(switch)
            fixed = switch.sensitivity
    y, rate, J = samples.results()
    return TwinRun(y=y, rate=rate, jacobian=J, switching=tuple(switching), end=state)


def _stretches(excitation: Excitation, state: TwinState, end: float) -> Iterator[tuple[FloatArray, float]]:
    """Yield the inputs between edges, from the current state on, with the instant until which they hold.

    An edge at that very instant comes first; applying it twice does no harm.
    """
    # Instants that differ by rounding count as one.
    ahead = (excitation.times >= state.time - 1e-12) & (excitation.times < end)
    stops = np.maximum(np.append(excitation.times[ahead], end), state.time)
    yield from zip([state.inputs, *excitation.values[ahead]], stops.tolist(), strict=True)


@dataclass(frozen=True)
class Twin:
    """A plant at given parameters: its start, flow and switching."""

    equations: Equations
    p: FloatArray
    sensitive: tuple[int, ...]
    tolerance: float

    def start(self, inputs: FloatArray, start_angle_rad: float) -> TwinState:
        """Return the state at the start of a record: currents settled, gear unwound, filter at rest."""
        modes = (0,) * len(self.equations.entry)
        at = ([start_angle_rad], *self._others(inputs, modes))
        s = self.equations.initial(*at)
        S = self.equations.initial.by_parameter(*at)[:, list(self.sensitive)]
        state = TwinState(time=0.0, s=s, S=S, inputs=inputs, modes=modes, armed=())
        # Twice, since an entry rule may depend on the mode of another switch.
        for k in (*range(len(modes)), *range(len(modes))):
            state = self._with_mode(state, k, self._entry_mode(state, k))
        return state

    def arc(self, state: TwinState, end: float, samples: _Samples) -> tuple[TwinState, Fired | None]:
        """Integrate to `end`, or to the first guard that reaches zero, and take samples on the way."""
        solver = self._solver(state, end)
        while True:
            solver.step()
            if solver.status == "failed":
                raise ArithmeticError(f"the twin's integrator fails at {solver.t} s")
            piece = solver.dense_output()
            state, time, fired = self._first_guard(state, piece)
            samples.take(state, piece, time)
            if fired is not None or solver.status == "finished":
                return self.state_on(piece, time, state), fired

    def guard_below_zero(self, state: TwinState, interval: float) -> Fired | None:
        """Return the first guard that a jump has left below zero; it fires together with that jump."""
        for k, mode in enumerate(state.modes):
            margins, at = self.equations.margins[k][mode], self.at(state)
            # Measured by the margin's own change over a sample, since margins have different units.
            limits = -THROWN * interval * np.abs(margins.by_state(*at) @ self.flow(state))
            below = np.flatnonzero(margins(*at) < limits)
            if below.size:
                return k, int(below[0])
        return None

    def fire_guard(
        self, state: TwinState, switch: int, guard: int, dtau: FloatArray | None = None
    ) -> tuple[TwinState, TwinSwitch]:
        """Return the state after a guard has fired: S+ = S- + (f- - f+) dtau/dp, resets included.

        `dtau`, (m,), is given if the instant is that of a jump.
        """
        declared = self.equations.plant.switches[switch]
        names, before = list(declared.modes), state.modes[switch]
        rule = declared.guards[names[before]][guard]
        # The instant of a jump does not depend on this guard's margin, but on the edge or switch that caused it.
        if dtau is None:
            dtau = self._instant_derivative(state, switch, guard)
        s, S = state.s.copy(), state.S + np.outer(self.flow(state), dtau)
        for symbol, value in rule.resets.items():
            k = self.equations.states.index(symbol)
            s[k], S[k] = value, 0.0
        new = replace(state, s=s, S=S)
        after = names.index(rule.target) if rule.target else self._entry_mode(new, switch)
        # The flow jumps with the mode: f- is taken before this line, f+ after it.
        new = self._with_mode(new, switch, after)
        new = replace(new, S=new.S - np.outer(self.flow(new), dtau))
        return new, TwinSwitch(time=state.time, switch=switch, before=before, after=after, sensitivity=dtau)

    def flow(self, state: TwinState) -> FloatArray:
        """Return ds/dt, (n,)."""
        return self.equations.rates(*self.at(state))

    def at(self, state: TwinState) -> tuple[Sequence[float], ...]:
        """Return the arguments of the equations."""
        return (state.s.tolist(), *self._others(state.inputs, state.modes))

    def state_on(self, piece: DenseOutput, time: float, state: TwinState) -> TwinState:
        """Return the state at an instant of a step, with the modes and inputs of `state`."""
        flat, n = piece(time), len(self.equations.states)
        return replace(state, time=time, s=flat[:n], S=flat[n:].reshape(n, -1) / self._scale)

    def margin(self, state: TwinState, piece: DenseOutput, fired: Fired, times: FloatArray) -> FloatArray:
        """Return a guard's margin at instants of a step."""
        switch, guard = fired
        margins = self.equations.margins[switch][state.modes[switch]]
        states = piece(times)[: len(self.equations.states)]
        values: FloatArray = margins.along(states, *self._others(state.inputs, state.modes))[guard]
        return values

    def outputs_on(self, state: TwinState, piece: DenseOutput, times: FloatArray) -> FloatArray:
        """Return the outputs, (n, n_y), at instants of a step."""
        states = piece(times)[: len(self.equations.states)]
        return self.equations.outputs.along(states, *self._others(state.inputs, state.modes)).T

    def measured_with_derivatives(self, state: TwinState) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return y (n_y,), dy/dt (n_y,) and dy/dp (n_y, m) at a state."""
        outputs, at = self.equations.outputs, self.at(state)
        y_s, y_p = outputs.by_state(*at), outputs.by_parameter(*at)[:, list(self.sensitive)]
        return outputs(*at), y_s @ self.flow(state), y_s @ state.S + y_p

    def _others(self, inputs: FloatArray, modes: Sequence[int]) -> tuple[Sequence[float], ...]:
        return (inputs.tolist(), self.equations.mode_symbols(modes), self.p.tolist())

    @property
    def _scale(self) -> FloatArray:
        """Scale of S, which is integrated per relative change of a parameter so that one tolerance suits all."""
        own = np.abs(self.p[list(self.sensitive)])
        return np.where(own > 0.0, own, 1.0)

    def _solver(self, state: TwinState, end: float) -> DOP853:
        flat, tolerance = np.concatenate([state.s, (state.S * self._scale).ravel()]), self.tolerance
        return DOP853(self._rates(state), state.time, flat, end, rtol=tolerance, atol=ABSOLUTE * tolerance)

    def _rates(self, state: TwinState) -> Callable[[float, FloatArray], FloatArray]:
        rates, n, columns = self.equations.rates, state.s.size, list(self.sensitive)
        others, scale = self._others(state.inputs, state.modes), self._scale

        def flow(_: float, flat: FloatArray) -> FloatArray:
            at = (flat[:n].tolist(), *others)
            if not columns:
                return rates(*at)
            S = flat[n:].reshape(n, -1)
            S_flow = rates.by_state(*at) @ S + rates.by_parameter(*at)[:, columns] * scale
            return np.concatenate([rates(*at), S_flow.ravel()])

        return flow

    def _first_guard(self, state: TwinState, piece: DenseOutput) -> tuple[TwinState, float, Fired | None]:
        """Return the first guard to fire within a step and its instant, with the state's armed flags updated."""
        first, fired = float(piece.t), None
        armed = [list(flags) for flags in state.armed]
        for k, flags in enumerate(armed):
            for g, flag in enumerate(flags):

                def margin(times: FloatArray, guard: Fired = (k, g)) -> FloatArray:
                    return self.margin(state, piece, guard, times)

                at, flags[g] = first_zero(margin, piece.t_old, piece.t, flag)
                if at is not None and (fired is None or at < first):
                    first, fired = at, (k, g)
        return replace(state, armed=tuple(map(tuple, armed))), first, fired

    def _instant_derivative(self, state: TwinState, switch: int, guard: int) -> FloatArray:
        """Return dtau/dp = -(g_s S + g_p) / (g_s f), (m,)."""
        margins, at = self.equations.margins[switch][state.modes[switch]], self.at(state)
        g_s, g_p = margins.by_state(*at)[guard], margins.by_parameter(*at)[guard, list(self.sensitive)]
        dtau: FloatArray = -(g_s @ state.S + g_p) / (g_s @ self.flow(state))
        return dtau

    def _entry_mode(self, state: TwinState, switch: int) -> int:
        """Return the mode that a switch's entry rules select."""
        declared = self.equations.plant.switches[switch]
        rules = self.equations.entry[switch](*self.at(state))
        chosen = (mode for (_, mode), value in zip(declared.entry, rules, strict=True) if value > 0.0)
        return list(declared.modes).index(next(chosen, declared.otherwise))

    def _with_mode(self, state: TwinState, switch: int, mode: int) -> TwinState:
        """Return the state in another mode; guards whose margin is above zero there are armed."""
        modes = tuple(mode if k == switch else old for k, old in enumerate(state.modes))
        new = replace(state, modes=modes)
        margins = [self.equations.margins[k][m](*self.at(new)) for k, m in enumerate(modes)]
        return replace(new, armed=tuple(tuple(bool(v > 0.0) for v in values) for values in margins))


class _Samples:
    """Samples of a run, filled as it proceeds; `after` counts those taken."""

    def __init__(self, twin: Twin, times: FloatArray, begin: float) -> None:
        n, n_y, m = times.size, len(twin.equations.outputs.expressions), len(twin.sensitive)
        self.twin, self.times, self.interval = twin, times, times[1] - times[0]
        self.y, self.rate, self.J = np.zeros((n, n_y)), np.zeros((n, n_y)), np.zeros((n, n_y, m))
        self.after = int(np.searchsorted(times, begin - 1e-12))

    def take(self, state: TwinState, piece: DenseOutput, end: float) -> None:
        """Take the samples of a step up to `end`."""
        first, self.after = self.after, int(np.searchsorted(self.times, end, side="right"))
        if first == self.after:
            return
        self.y[first : self.after] += self.twin.outputs_on(state, piece, self.times[first : self.after])
        for row in range(first, self.after) if self.twin.sensitive else ():
            _, rate, J = self.twin.measured_with_derivatives(self.twin.state_on(piece, self.times[row], state))
            self.rate[row] += rate
            self.J[row] += J

    def jump(self, before: TwinState, after: TwinState, switch: TwinSwitch) -> None:
        """Correct the sample at the interval's end for a jump, so that it is the mean over the interval."""
        passed = switch.time - (self.times[min(self.after, len(self.times) - 1)] - self.interval)
        if passed < 0.0 or self.after == len(self.times):
            return
        (y_0, rate_0, J_0), (y_1, rate_1, J_1) = map(self.twin.measured_with_derivatives, (before, after))
        rise, dtau = (y_1 - y_0) / self.interval, switch.sensitivity
        rise_p = (J_1 - J_0 + np.outer(rate_1 - rate_0, dtau)) / self.interval
        self.y[self.after] -= rise * passed
        self.rate[self.after] += rise
        self.J[self.after] -= rise_p * passed + np.outer(rise, dtau)

    def results(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return y, dy/dt and dy/dp."""
        return self.y, self.rate, self.J
