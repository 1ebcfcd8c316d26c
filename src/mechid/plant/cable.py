"""Cables from the base to the load of a drive train: a spring about a rest angle, optionally with Dahl hysteresis."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from sympy import Expr, Integer, Symbol, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block, Guard, Switch
from mechid.plant.drive_train import alpha_gear, omega_gear

TABLE = "load.cable"
DAHL = "Dahl, AIAA J. 14 (1976) 1675-1682"
_parameter = partial(Declaration, source=DAHL)
K_c, alpha_c, T_cable = symbols("K_c alpha_c T_cable")
SPRING = K_c * (alpha_gear - alpha_c)


def spring() -> Block:
    """Cables as a spring: T_cable = K_c (alpha_gear - alpha_c), from the load to the base; N m, rad."""
    return _cable(SPRING)


def dahl() -> Block:
    """Cables whose strands rub: T_cable = K_c (alpha_gear - alpha_c) + T_h h, theta_h h' = omega_gear - |omega_gear| h.

    Dahl (1976) with exponent 1, scaled: h within [-1, 1] is the fraction of the hysteresis torque T_h (N m) that has
    built up, theta_h (rad) the angle over which it builds up after a reversal, so that the stiffness
    there is K_c + T_h/theta_h. The torque is linear in the amplitude T_h. A record begins with h = 0. The
    zeros of the speed, where |omega_gear| has its kink, are located exactly.
    """
    T_h, theta_h, h, direction = symbols("T_h theta_h h_cable direction_cable")
    own = (
        _parameter("hysteresis", T_h.name, "N m", "half the width of the cables' hysteresis loop", lower=0.0),
        _parameter(
            "hysteresis_angle", theta_h.name, "rad", "angle of the load over which the hysteresis builds up", lower=0.0
        ),
    )
    # A switch locates the zeros of the speed, so that no integration step straddles the kink of its magnitude.
    switch = Switch(
        name=TABLE,
        modes={"forward": {direction: 1.0}, "backward": {direction: -1.0}},
        guards={
            "forward": (Guard(margin=omega_gear, target="backward"),),
            "backward": (Guard(margin=-omega_gear, target="forward"),),
        },
        entry=((-omega_gear, "backward"),),
        otherwise="forward",
        ideal={direction: 0.0},
    )
    return _cable(SPRING + T_h * h, own, {h: omega_gear * (1 - direction * h) / theta_h}, switch)


def _cable(
    torque: Expr,
    own: tuple[Declaration, ...] = (),
    rates: Mapping[Symbol, Expr] | None = None,
    switch: Switch | None = None,
) -> Block:
    rates = rates or {}
    return Block(
        name="cable",
        table=TABLE,
        declarations=(
            _parameter("stiffness", K_c.name, "N m/rad", "stiffness of the cables about the output axis", lower=0.0),
            _parameter(
                "rest_angle", alpha_c.name, "rad", "angle of the load at which the cables pull neither way", default=0.0
            ),
            *own,
        ),
        terms={T_cable: torque},
        rates=rates,
        initial=dict.fromkeys(rates, Integer(0)),
        outputs={T_cable.name: T_cable},
        switch=switch,
        # The hysteresis relaxes and does not oscillate.
        swinging=dict.fromkeys(rates, ""),
        reference=DAHL,
    )


LAWS: Mapping[str, Callable[[], Block]] = {"spring": spring, "dahl": dahl}
"""Cable models by their names in mechanism.toml; the first is the default."""
