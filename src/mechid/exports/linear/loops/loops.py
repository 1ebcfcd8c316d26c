"""Loops of the electronics around the linear models of a mechanism: numbers, blocks, remarks."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from mechid.errors import InputFileError
from mechid.exports.linear.draws import physical_draws
from mechid.exports.linear.linearisation import HeldMechanism
from mechid.exports.linear.loops.bands import LoopNumbers, StepResponse, loop_numbers, step_response
from mechid.exports.linear.loops.closing import (
    CURRENTS,
    PHASES,
    QUADRATURE,
    REFERENCE,
    REFERENCES,
    VOLTAGE_INPUTS,
    DrivenPlant,
    Loop,
    close_current_loops,
    close_position_loop,
    drive_train_mode,
    moves_sensor,
    position_plant,
    sense_of,
)
from mechid.exports.linear.loops.loop_file import CURRENT, POSITION, LoopDesign, Notch
from mechid.exports.linear.loops.margins import unstable_pole
from mechid.exports.linear.loops.sample_by_sample import NonlinearPlant
from mechid.exports.linear.loops.sampled import Sampled
from mechid.exports.linear.loops.sweep import Sweep, refuse_departure, sweep_loop
from mechid.exports.linear.loops.trade import Holding, NotchChoice, holding_of, trade_notch, trade_table
from mechid.exports.linear.state_space import LinearModel, Matrices
from mechid.identification.computation.parallel import one_core_algebra

DRAWS, TRADED = 200, 60
"""Plants drawn from the covariance for the bands, and how many of them the trade of the notch uses."""


@dataclass(frozen=True, eq=False)
class ClosedLoop:
    """A loop around one model, with its numbers.

    Attributes
    ----------
    loop : Loop
    numbers : LoopNumbers
    step : StepResponse
    sweep : Sweep or None
        The same loop around the nonlinear equations; None if its crossovers are too slow for a run.
    """

    loop: Loop
    numbers: LoopNumbers
    step: StepResponse
    sweep: Sweep | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the content of linear.json."""
        blocks = {name: _block(getattr(self.loop, name)) for name in ("controller", "plant", "open", "closed")}
        return {
            **self.numbers.to_dict(),
            "step": self.step.to_dict(),
            "blocks": blocks,
            "sweep": self.sweep.to_dict() if self.sweep else None,
        }


@dataclass(frozen=True, eq=False)
class ClosedPosition:
    """The position loop around one model, with what it does to the drive train.

    Attributes
    ----------
    closed : ClosedLoop
    mode_hz, mode_damping : float
        Drive-train mode before the loop is closed.
    notch : Notch or None
        Notch of the loop, with its frequency.
    sign : float
        Sense in which a positive quadrature command turns the sensor.
    holding : Holding
    trade : tuple of NotchChoice
    """

    closed: ClosedLoop
    mode_hz: float
    mode_damping: float
    notch: Notch | None
    sign: float
    holding: Holding
    trade: tuple[NotchChoice, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return the content of linear.json."""
        return {
            **self.closed.to_dict(),
            "mode": {"frequency_hz": self.mode_hz, "damping": self.mode_damping},
            "notch": asdict(self.notch) if self.notch else None,
            "sign": self.sign,
            **self.holding.to_dict(),
            "trade": trade_table(self.trade),
        }


@dataclass(frozen=True, eq=False)
class Loops:
    """Closed loops of the electronics.

    Attributes
    ----------
    design : LoopDesign
    current : mapping of model to mapping of phase to ClosedLoop
    position : mapping of model to ClosedPosition
        For the models whose sensor the currents move.
    words : tuple of str
        Remarks for the user, one sentence each.
    """

    design: LoopDesign
    current: Mapping[str, Mapping[str, ClosedLoop]]
    position: Mapping[str, ClosedPosition]
    words: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return the content of linear.json."""
        return {
            "design": self.design.to_dict(),
            "current": {
                name: {phase: loop.to_dict() for phase, loop in loops.items()} for name, loops in self.current.items()
            },
            "position": {name: loop.to_dict() for name, loop in self.position.items()},
        }


def close_loops(
    held: HeldMechanism, models: Mapping[str, LinearModel], design: LoopDesign, count: int, seed: int
) -> Loops:
    """Close the loops of a design around linear models, with bands over `count` drawn plants.

    Raises
    ------
    InputFileError
        A closed loop is unstable, or the mechanism has no such loop.
    FitError
        Too few draws from the covariance are physical, or the nonlinear equations have other margins.
    """
    _refuse(held, design)
    values = physical_draws(held.opened.mechanism, held.uncertain, count, seed)
    changed = [dict(zip(held.uncertain.names, draw.tolist(), strict=True)) for draw in values]
    current: dict[str, dict[str, ClosedLoop]] = {}
    position: dict[str, ClosedPosition] = {}
    # The matrices are small: threads would only wait for each other.
    with one_core_algebra():
        for name, model in models.items():
            kept = held.moving_states(name)
            matrices = [model.matrices, *(held.matrices_at(name, values, kept) for values in changed)]
            plants = [_plant(held, model, one) for one in matrices]
            inner = [close_current_loops(plant, design.current) if design.current else {} for plant in plants]
            if design.current:
                _refuse_unstable(inner[0][PHASES[0]].closed, design, CURRENT, name)
                current[name] = {phase: _current_numbers(phase, inner) for phase in PHASES}
            driven = (
                [
                    position_plant(plant, design, loops.get(PHASES[0]))
                    for plant, loops in zip(plants, inner, strict=True)
                ]
                if design.position
                else []
            )
            if driven and moves_sensor(driven[0], design):
                position[name] = _close_position(driven, design, name)
            current, position = _measure(NonlinearPlant(held, model), design, current, position)
    _refuse_unmoved(position, design)
    return Loops(design, current, position, tuple(_words(current, position)))


def _measure(
    plant: NonlinearPlant,
    design: LoopDesign,
    current: dict[str, dict[str, ClosedLoop]],
    position: dict[str, ClosedPosition],
) -> tuple[dict[str, dict[str, ClosedLoop]], dict[str, ClosedPosition]]:
    """Add the sweeps of one model's loops through the nonlinear equations."""
    name = plant.model.name

    def sweep_one(closed: ClosedLoop, driven: str, words: str) -> ClosedLoop:
        sweep = sweep_loop(plant, design, closed.loop, driven)
        if sweep:
            refuse_departure(sweep, words)
        return replace(closed, sweep=sweep)

    if name in current:
        loops = current[name].items()
        own = {x: sweep_one(one, one.loop.controller.outputs[0], f"current loop of {x}") for x, one in loops}
        current = {**current, name: own}
    if name in position:
        closed = sweep_one(position[name].closed, QUADRATURE, "position loop")
        position = {**position, name: replace(position[name], closed=closed)}
    return current, position


def _current_numbers(phase: str, inner: Sequence[Mapping[str, Loop]]) -> ClosedLoop:
    """Return the numbers of one phase's loop; the nominal plant comes first."""
    own, *drawn = (loops[phase] for loops in inner)
    k = PHASES.index(phase)
    shown = (CURRENTS[k], CURRENTS[1 - k], f"control_{VOLTAGE_INPUTS[k]}")
    step = step_response(own.closed, [loop.closed for loop in drawn], REFERENCES[k], shown)
    return ClosedLoop(own, loop_numbers(own, drawn), step)


def _close_position(driven: Sequence[Sampled], design: LoopDesign, name: str) -> ClosedPosition:
    """Close the position loop around its plants; the nominal one comes first."""
    assert design.position is not None
    loop, half = design.position, driven[0].nyquist_hz
    mode_hz, damping = drive_train_mode(driven[0], loop.sensor) or (half / 2.0, 1.0)
    sign = sense_of(driven[0], loop.sensor)
    centre = Notch() if loop.notch is None else loop.notch
    notch = centre if centre.frequency_hz else replace(centre, frequency_hz=mode_hz)
    used = notch if loop.notch else None
    own, *drawn = (close_position_loop(plant, design, used, sign) for plant in driven)
    _refuse_unstable(own.closed, design, POSITION, name)
    shown = (loop.sensor, f"control_{QUADRATURE}")
    step = step_response(own.closed, [one.closed for one in drawn], REFERENCE, shown)
    return ClosedPosition(
        closed=ClosedLoop(own, loop_numbers(own, drawn), step),
        mode_hz=mode_hz,
        mode_damping=damping,
        notch=used,
        sign=sign,
        holding=holding_of(own, drawn, mode_hz),
        trade=trade_notch(driven[0], driven[1 : 1 + TRADED], design, notch, mode_hz, sign),
    )


def _plant(held: HeldMechanism, model: LinearModel, matrices: Matrices) -> DrivenPlant:
    return DrivenPlant(matrices, model.inputs.names, model.outputs.names, held.command.start_angle_rad)


def _refuse(held: HeldMechanism, design: LoopDesign) -> None:
    """Refuse a current loop around a drive that is given as commanded currents."""
    if design.current and VOLTAGE_INPUTS[0] not in held.opened.inputs:
        raise InputFileError(
            f"{design.file}: {CURRENT}: the mechanism's drive is given as commanded currents, whose coils have no "
            "equation here; leave the table out, or identify with a voltage drive"
        )


def _refuse_unmoved(position: Mapping[str, ClosedPosition], design: LoopDesign) -> None:
    """Refuse a position loop whose sensor no current moves in any model."""
    if design.position and not position:
        raise InputFileError(
            f"{design.file}: {POSITION}.sensor: the currents do not move {design.position.sensor} in any linear model; "
            "the mechanism has no such output"
        )


def _refuse_unstable(closed: Sampled, design: LoopDesign, table: str, model: str) -> None:
    """Raise InputFileError with the pole of an unstable loop."""
    pole = unstable_pole(closed)
    if pole is None:
        return
    s = cmath.log(pole) / closed.period_s
    hertz = abs(s.imag) / (2.0 * math.pi)
    imaginary = f" +- {pole.imag:.4g}i" if pole.imag > 1e-12 else ""
    raise InputFileError(
        f'{design.file}: {table}: with these gains the loop around "{model}" is unstable: pole at z = '
        f"{pole.real:.4g}{imaginary}, {hertz:.4g} Hz, growing by the factor {abs(pole):.4g} in each sample of "
        f"{closed.period_s:g} s; lower the gains, or shorten the delay"
    )


def _words(current: Mapping[str, Mapping[str, ClosedLoop]], position: Mapping[str, ClosedPosition]) -> Iterator[str]:
    for name, loops in current.items():
        for phase, one in loops.items():
            yield f'Current loop of {phase} around "{name}": {margin_words(one.numbers)}.'
    for name, own in position.items():
        yield f'Position loop around "{name}": {margin_words(own.closed.numbers)}.'
        damping = own.holding.damping
        yield (
            f"Its drive-train mode at {own.mode_hz:.4g} Hz has the damping ratio {own.mode_damping:.3g} open, and "
            f"{float(damping.value):.3g} ({float(damping.low):.3g} to {float(damping.high):.3g}) with the loop closed."
        )
    yield sweep_words(
        [one for loops in current.values() for one in loops.values()] + [p.closed for p in position.values()]
    )


def sweep_words(loops: Sequence[ClosedLoop]) -> str:
    """Return how far the margins of swept sines are from those of the linear loops."""
    done = [one.sweep for one in loops if one.sweep]
    if not done:
        return "No sine was swept through the nonlinear equations: the loops' crossovers are too slow."
    dB, deg = max(abs(one.gain_error_dB) for one in done), max(abs(one.phase_error_deg) for one in done)
    return (
        "Closed sample by sample around the nonlinear equations, with swept sines, "
        f"{len(done)} of {len(loops)} loops have the same margins to {dB:.2g} dB and {deg:.2g} deg."
    )


def margin_words(numbers: LoopNumbers) -> str:
    """Return gain and phase margin with their bands in words."""
    parts = []
    for name, words, unit in (("gain_dB", "gain margin", "dB"), ("phase_deg", "phase margin", "deg")):
        band = numbers.bands[name]
        low, high = f"{band.low:.4g}", f"{band.high:.4g}"
        if np.isfinite(band.value):
            parts.append(f"{words} {band.value:.4g} {unit} ({low} to {high} in 95 % of the draws)")
        else:
            parts.append(f"{words} unlimited")
    if numbers.unstable_draws:
        parts.append(f"UNSTABLE in {numbers.unstable_draws} of {numbers.draws} draws")
    return ", ".join(parts)


def _block(of: Sampled) -> dict[str, Any]:
    return {**of.matrices.to_dict(), "period_s": of.period_s, "inputs": list(of.inputs), "outputs": list(of.outputs)}
