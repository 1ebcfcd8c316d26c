"""Trade of stiffness and damping over the depth of a notch at the drive-train mode.

For each depth all gains of the position loop are multiplied by one factor: the largest with which 97.5 % of the drawn
plants keep a gain margin of 6 dB and a phase margin of 30 deg, the limits of `GAIN_DB` and `PHASE_DEG`. A deeper notch
lets the gains and thereby the stiffness rise, and leaves less of the controller to damp the mode.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mechid.arrays import FloatArray
from mechid.exports.linear.loops.bands import LEVELS, Band, band_of
from mechid.exports.linear.loops.closing import (
    OUTPUT,
    Loop,
    close_position_loop,
    modes_of,
)
from mechid.exports.linear.loops.loop_file import LoopDesign, Notch, PositionLoop
from mechid.exports.linear.loops.margins import loop_frequencies, unstable_pole
from mechid.exports.linear.loops.sampled import Sampled
from mechid.plant.ports import PUSH

DEPTHS = (None, 0.7, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02)
"""Compared depths; None is no notch."""
GAIN_DB, PHASE_DEG = 6.0, 30.0
"""Margins that are kept: the least that requirements of pointing loops usually ask for."""
SLOW = 0.1
"""Frequency of the stiffness, as a share of the mode's."""
NEAR = (0.5, 2.0)
"""Range of frequencies in which a pole of the closed loop is that of the mode, relative to it."""
ROTOR = "rotor_angle"


@dataclass(frozen=True, eq=False)
class Holding:
    """Stiffness and damping of the output under a closed position loop.

    Attributes
    ----------
    stiffness : Band
        Torque over angle of the output at a tenth of the mode's frequency, N m/rad; NaN without a torque input.
    least_stiffness : Band
        Least over all frequencies.
    damping : Band
        Least damping ratio of the closed poles near the mode.
    """

    stiffness: Band
    least_stiffness: Band
    damping: Band

    def to_dict(self) -> dict[str, Any]:
        """Return the content of linear.json."""
        return {name: getattr(self, name).to_dict() for name in ("stiffness", "least_stiffness", "damping")}


@dataclass(frozen=True, eq=False)
class NotchChoice:
    """One depth of the notch.

    Attributes
    ----------
    depth : float or None
        None without a notch.
    factor : float or None
        Factor on the gains; None if no factor keeps the margins with a stable loop.
    holding : Holding or None
    """

    depth: float | None
    factor: float | None
    holding: Holding | None


def trade_table(choices: Sequence[NotchChoice]) -> dict[str, Any]:
    """Return a trade as columns over the depth, as linear.json has it; null without a notch, or without a factor."""
    none = dict.fromkeys(("value", "low", "high"))
    held = [choice.holding.to_dict() if choice.holding else {} for choice in choices]
    return {
        "depth": [choice.depth for choice in choices],
        "factor": [choice.factor for choice in choices],
        **{
            name: {end: [one.get(name, none)[end] for one in held] for end in none}
            for name in ("stiffness", "least_stiffness", "damping")
        },
    }


def holding_of(nominal: Loop, draws: Sequence[Loop], mode_hz: float) -> Holding:
    """Return stiffness and damping of closed position loops, with bands over draws."""
    hertz = np.unique(np.concatenate([loop_frequencies(nominal.open), [SLOW * mode_hz]]))
    every = [_hold(loop.closed, hertz, mode_hz) for loop in (nominal, *draws)]
    values = np.array(every)
    return Holding(*(band_of(values[0, k], values[1:, k]) for k in range(3)))


def trade_notch(
    nominal: Sampled, draws: Sequence[Sampled], design: LoopDesign, notch: Notch, mode_hz: float, sign: float
) -> tuple[NotchChoice, ...]:
    """Return the trade over the depths of a notch.

    Parameters
    ----------
    nominal : Sampled
        Plant of the position loop.
    draws : sequence of Sampled
        The same of drawn plants.
    design : LoopDesign
    notch : Notch
        Notch with frequency and damping; its depth is varied.
    mode_hz : float
        Frequency of the drive-train mode.
    sign : float
        Sense of the sensor.
    """
    return tuple(_choose(nominal, draws, design, notch, depth, mode_hz, sign) for depth in DEPTHS)


def _choose(
    nominal: Sampled,
    draws: Sequence[Sampled],
    design: LoopDesign,
    notch: Notch,
    depth: float | None,
    mode_hz: float,
    sign: float,
) -> NotchChoice:
    own = None if depth is None else replace(notch, depth=depth)
    loops = [close_position_loop(plant, design, own, sign) for plant in (nominal, *draws)]
    hertz = loop_frequencies(loops[0].open)
    factors = [largest_factor(loop.open.response(hertz)[:, 0, 0]) for loop in loops]
    # The nominal plant keeps the margins too.
    factor = min(factors[0], float(np.quantile(factors, LEVELS[0], method="lower")))
    if not np.isfinite(factor):
        return NotchChoice(depth, None, None)
    scaled = replace(design, position=scale_gains(design.position, factor)) if design.position else design
    closed = [close_position_loop(plant, scaled, own, sign) for plant in (nominal, *draws)]
    if unstable_pole(closed[0].closed) is not None:
        return NotchChoice(depth, None, None)
    return NotchChoice(depth, factor, holding_of(closed[0], closed[1:], mode_hz))


def scale_gains(loop: PositionLoop, factor: float) -> PositionLoop:
    """Return a position loop with all gains multiplied by a factor."""
    return replace(loop, kp=factor * loop.kp, ki=factor * loop.ki, kd=factor * loop.kd)


def largest_factor(response: np.ndarray[Any, Any]) -> float:
    """Return the largest factor on an open loop, (f,), that keeps both margins.

    The loop times the factor stays out of the sector |arg(-L)| < 30 deg beyond |L| = 1, and crosses the negative axis
    below -6 dB.
    """
    size, angle = np.abs(response), np.degrees(np.angle(-response))
    sector = size[np.abs(angle) < PHASE_DEG].max(initial=0.0)
    across = np.flatnonzero((np.sign(angle[:-1]) != np.sign(angle[1:])) & (np.abs(np.diff(angle)) < 180.0))
    axis = max((max(size[k], size[k + 1]) for k in across), default=0.0) * 10.0 ** (GAIN_DB / 20.0)
    most = max(float(sector), float(axis))
    return 1.0 / most if most > 0.0 else np.inf


def _hold(closed: Sampled, hertz: FloatArray, mode_hz: float) -> tuple[float, float, float]:
    """Return stiffness at a low frequency, least stiffness, and damping of the mode."""
    output = OUTPUT if OUTPUT in closed.outputs else ROTOR
    low = least = float("nan")
    if PUSH.name in closed.inputs:
        gives = np.abs(closed.select((PUSH.name,), (output,)).response(hertz)[:, 0, 0])
        low = 1.0 / float(gives[np.searchsorted(hertz, SLOW * mode_hz)])
        least = 1.0 / float(gives.max())
    near = [zeta for f, zeta in modes_of(closed) if NEAR[0] * mode_hz < f < NEAR[1] * mode_hz]
    # Without a pair near the mode its motion no longer swings.
    return low, least, min(near, default=1.0)
