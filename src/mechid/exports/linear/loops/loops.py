"""Loops of the electronics around the linear models of a mechanism: numbers, blocks, remarks."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mechid.errors import InputFileError
from mechid.exports.linear.draws import physical_draws
from mechid.exports.linear.linearisation import HeldMechanism
from mechid.exports.linear.loops.bands import LoopNumbers, StepResponse, loop_numbers, step_response
from mechid.exports.linear.loops.closing import (
    CURRENTS,
    PHASES,
    REFERENCES,
    VOLTAGE_INPUTS,
    DrivenPlant,
    Loop,
    close_current_loops,
)
from mechid.exports.linear.loops.loop_file import CURRENT, LoopDesign
from mechid.exports.linear.loops.margins import unstable_pole
from mechid.exports.linear.loops.sampled import Sampled
from mechid.exports.linear.state_space import LinearModel, Matrices
from mechid.identification.computation.parallel import one_core_algebra

DRAWS = 200
"""Plants drawn from the covariance for the bands."""


@dataclass(frozen=True, eq=False)
class ClosedLoop:
    """A loop around one model, with its numbers.

    Attributes
    ----------
    loop : Loop
    numbers : LoopNumbers
    step : StepResponse
    """

    loop: Loop
    numbers: LoopNumbers
    step: StepResponse

    def to_dict(self) -> dict[str, Any]:
        """Return the content of linear.json."""
        blocks = {name: _block(getattr(self.loop, name)) for name in ("controller", "plant", "open", "closed")}
        return {**self.numbers.to_dict(), "step": self.step.to_dict(), "blocks": blocks}


@dataclass(frozen=True, eq=False)
class Loops:
    """Closed loops of the electronics.

    Attributes
    ----------
    design : LoopDesign
    current : mapping of model to mapping of phase to ClosedLoop
    words : tuple of str
        Remarks for the user, one sentence each.
    """

    design: LoopDesign
    current: Mapping[str, Mapping[str, ClosedLoop]]
    words: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return the content of linear.json."""
        return {
            "design": self.design.to_dict(),
            "current": {
                name: {phase: loop.to_dict() for phase, loop in loops.items()} for name, loops in self.current.items()
            },
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
        Too few draws from the covariance are physical.
    """
    _refuse(held, design)
    values = physical_draws(held.opened.mechanism, held.uncertain, count, seed)
    changed = [dict(zip(held.uncertain.names, draw.tolist(), strict=True)) for draw in values]
    current: dict[str, dict[str, ClosedLoop]] = {}
    # The matrices are small: threads would only wait for each other.
    with one_core_algebra():
        for name, model in models.items():
            kept = held.moving_states(name)
            plants = [_plant(held, model, held.matrices_at(name, values, kept)) for values in changed]
            nominal = _plant(held, model, model.matrices)
            if design.current:
                current[name] = _close_currents(nominal, plants, design, name)
    return Loops(design, current, tuple(_words(current)))


def _close_currents(
    nominal: DrivenPlant, plants: list[DrivenPlant], design: LoopDesign, name: str
) -> dict[str, ClosedLoop]:
    assert design.current is not None
    own = close_current_loops(nominal, design.current)
    _refuse_unstable(own[PHASES[0]].closed, design, CURRENT, name)
    drawn = [close_current_loops(plant, design.current) for plant in plants]
    out = {}
    for k, phase in enumerate(PHASES):
        others = [loops[phase] for loops in drawn]
        closed = [loop.closed for loop in others]
        shown = (CURRENTS[k], CURRENTS[1 - k], f"control_{VOLTAGE_INPUTS[k]}")
        step = step_response(own[phase].closed, closed, REFERENCES[k], shown)
        out[phase] = ClosedLoop(own[phase], loop_numbers(own[phase], others), step)
    return out


def _plant(held: HeldMechanism, model: LinearModel, matrices: Matrices) -> DrivenPlant:
    return DrivenPlant(matrices, model.inputs.names, model.outputs.names, held.command.start_angle_rad)


def _refuse(held: HeldMechanism, design: LoopDesign) -> None:
    """Refuse a current loop around a drive that is given as commanded currents."""
    if design.current and VOLTAGE_INPUTS[0] not in held.opened.inputs:
        raise InputFileError(
            f"{design.file}: {CURRENT}: the mechanism's drive is given as commanded currents, whose coils have no "
            "equation here; leave the table out, or identify with a voltage drive"
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


def _words(current: Mapping[str, Mapping[str, ClosedLoop]]) -> Iterator[str]:
    for name, loops in current.items():
        for phase, one in loops.items():
            yield f'Current loop of {phase} around "{name}": {margin_words(one.numbers)}.'


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
