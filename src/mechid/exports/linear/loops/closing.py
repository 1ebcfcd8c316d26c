"""Current and position loop closed around a linear model.

The currents of both phases have a controller each; the loop of one phase is opened while that of the other is closed,
with which the back-EMF couples it. The position loop commands quadrature current: at the held electrical angle theta
the currents -I cos(theta), I sin(theta) change by q sin(theta), q cos(theta), as if the commanded angle turned by q/I.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mechid.exports.linear.loops.controllers import current_controller, parallel, position_controller
from mechid.exports.linear.loops.loop_file import CurrentLoop, LoopDesign, Notch
from mechid.exports.linear.loops.sampled import ROUNDING, Sampled, close, hold, lift, series
from mechid.exports.linear.state_space import Matrices
from mechid.plant.ports import ADDED, PUSH

PHASES = ("phase_a", "phase_b")
CURRENTS = tuple(f"current_{phase}" for phase in PHASES)
VOLTAGE_INPUTS = (ADDED["u_A"].name, ADDED["u_B"].name)
CURRENT_INPUTS = (ADDED["i_A"].name, ADDED["i_B"].name)
REFERENCES = tuple(f"reference_{name}" for name in CURRENTS)
QUADRATURE, REFERENCE = "quadrature", "reference"
OUTPUT = "output_angle"


@dataclass(frozen=True, eq=False)
class DrivenPlant:
    """Continuous linear model with the names of its signals, and the held electrical angle in rad."""

    matrices: Matrices
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    angle_rad: float

    @property
    def phases(self) -> tuple[str, str]:
        """Names of the inputs of the phases: voltages, or currents of a current drive."""
        return VOLTAGE_INPUTS if VOLTAGE_INPUTS[0] in self.inputs else CURRENT_INPUTS


@dataclass(frozen=True, eq=False)
class Loop:
    """A loop of one input and one output.

    Attributes
    ----------
    plant : Sampled
        Plant as its controller sees it, with all inputs and outputs.
    controller : Sampled
    open : Sampled
        Controller and plant in series.
    closed : Sampled
        With references first and the disturbances behind; its outputs are the plant's and the controller's.
    """

    plant: Sampled
    controller: Sampled
    open: Sampled
    closed: Sampled


def close_current_loops(plant: DrivenPlant, loop: CurrentLoop) -> dict[str, Loop]:
    """Return the current loop of each phase, by the phase's name; all have the same closed system."""
    period_s, delay_s = loop.timing.period_s, loop.timing.delay_s
    held = hold(plant.matrices, plant.inputs, plant.outputs, period_s, delayed=plant.phases, delay_s=delay_s)
    ways = list(zip(CURRENTS, plant.phases, strict=True))
    own = [current_controller(loop, *way) for way in ways]
    closed = close(held, parallel(*own), REFERENCES)
    loops = {}
    for k, (sensed, driven) in enumerate(ways):
        other = close(held, own[1 - k], (REFERENCES[1 - k],))
        opened = series(own[k], other.select((driven,), (sensed,)))
        loops[PHASES[k]] = Loop(other, own[k], opened, closed)
    return loops


def position_plant(plant: DrivenPlant, design: LoopDesign, inner: Loop | None) -> Sampled:
    """Return the plant of the position loop, with the quadrature command as its last input.

    Parameters
    ----------
    plant : DrivenPlant
    design : LoopDesign
    inner : Loop or None
        One of the current loops; None for a drive without one.
    """
    assert design.position is not None
    timing = design.position.timing
    held: tuple[str, ...] = plant.phases
    if inner is None:
        sampled = hold(
            plant.matrices, plant.inputs, plant.outputs, timing.period_s, delayed=held, delay_s=timing.delay_s
        )
    else:
        held, fast_s = REFERENCES, inner.closed.period_s
        # The current controller reads a new reference at its next sample.
        late = math.ceil(timing.delay_s / fast_s - ROUNDING)
        sampled = lift(inner.closed, round(timing.period_s / fast_s), delayed=held, delay=late)
    along = (math.sin(plant.angle_rad), math.cos(plant.angle_rad))
    return sampled.combine_inputs(QUADRATURE, list(zip(held, along, strict=True)))


def close_position_loop(plant: Sampled, design: LoopDesign, notch: Notch | None, sign: float) -> Loop:
    """Return the position loop around the plant of `position_plant`; `notch` has its frequency."""
    assert design.position is not None
    controller = position_controller(design.position, QUADRATURE, notch, sign)
    opened = series(controller, plant.select((QUADRATURE,), (design.position.sensor,)))
    return Loop(plant, controller, opened, close(plant, controller, (REFERENCE,)))


def sense_of(plant: Sampled, sensor: str) -> float:
    """Return 1 if a slow positive quadrature command turns the sensor forward, -1 with a reversing gear."""
    slow = plant.select((QUADRATURE,), (sensor,)).response([1e-6 * plant.nyquist_hz])[0, 0, 0]
    return -1.0 if slow.real < 0.0 else 1.0


def modes_of(system: Sampled) -> list[tuple[float, float]]:
    """Return frequency in Hz and damping ratio of each pole pair, slowest first."""
    poles = system.poles
    # Poles at the origin are delays.
    s = np.log(poles[np.abs(poles) > 1e-9]) / system.period_s
    return sorted((abs(one) / (2.0 * math.pi), -one.real / abs(one)) for one in s.tolist() if one.imag > 1e-9)


def drive_train_mode(plant: Sampled, sensor: str) -> tuple[float, float] | None:
    """Return frequency in Hz and damping of the mode with the highest peak on the output; None without a mode."""
    modes = [mode for mode in modes_of(plant) if mode[0] < plant.nyquist_hz]
    way = ((PUSH.name,), (OUTPUT,)) if PUSH.name in plant.inputs and OUTPUT in plant.outputs else None
    path = plant.select(*(way or ((QUADRATURE,), (sensor,))))
    if not modes:
        return None
    peaks = np.abs(path.response([f for f, _ in modes])[:, 0, 0])
    return modes[int(np.argmax(peaks))]


def signal_units(plant: DrivenPlant, units: Mapping[str, str]) -> str:
    """Return the unit of the quadrature command."""
    return units[plant.phases[0]]
