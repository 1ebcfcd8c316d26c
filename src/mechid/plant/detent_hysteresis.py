"""Hysteresis of the detent torque: iron of the motor that lags behind the rotor's magnet.

T_hys = T_h h(alpha), (p/2) dalpha (1 - h sign(dalpha)) = theta_h dh: Dahl's model with exponent 1 over the electrical
angle. It takes the same work from each turn at any speed, and none from a rotor at rest.
"""

from __future__ import annotations

from functools import partial

from sympy import Expr, Float, Integer, pi, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block, Guard, Rival, Switch
from mechid.plant.drive_train import omega, p

TABLE = "stepper.detent_hysteresis"
DAHL = "Dahl, AIAA J. 14 (1976) 1675-1682"
T_hys = symbols("T_hys")
TYPICAL_ANGLE_DEG = 15.0
"""Electrical angle where the file gives none: a sixth of a full step, 0.3 deg of a rotor with 100 poles."""
_parameter = partial(Declaration, source=DAHL, lower=0.0)


def hysteresis() -> Block:
    """Hysteresis of the detent torque: T_hys = T_h h, theta_h h' = (p/2) (omega - |omega| h); N m, electrical rad.

    h within [-1, 1] is the share of the torque that has built up, theta_h the electrical angle over which it builds up
    after a reversal; a record begins with h = 0. The zeros of the speed, where |omega| has its kink, are located.
    """
    T_h, angle, h, direction = symbols("T_hd theta_hd h_detent direction_detent")
    switch = Switch(
        name=TABLE,
        modes={"forward": {direction: 1.0}, "backward": {direction: -1.0}},
        guards={
            "forward": (Guard(margin=omega, target="backward"),),
            "backward": (Guard(margin=-omega, target="forward"),),
        },
        entry=((-omega, "backward"),),
        otherwise="forward",
        ideal={direction: 0.0},
    )
    return Block(
        name="detent_hysteresis",
        table=TABLE,
        declarations=(
            _parameter("torque", T_h.name, "N m", "half the width of the hysteresis loop of the detent torque"),
            _parameter(
                "angle_deg",
                angle.name,
                "deg",
                "electrical angle over which the hysteresis builds up",
                default=TYPICAL_ANGLE_DEG,
            ),
        ),
        rates={h: p / 2 * omega * (1 - direction * h) / (angle * pi / 180)},
        initial={h: Integer(0)},
        outputs={T_hys.name: T_h * h},
        switch=switch,
        # The hysteresis relaxes and does not oscillate.
        swinging={h: ""},
        reference=DAHL,
    )


def rival(holding: Expr) -> Rival:
    """Return the hysteresis that may be added, with 2 % of the holding torque; at zero torque it vanishes.

    As a term of the library it would locate the zeros of the speed in every mechanism, and growth would not prune it.
    """
    return Rival(
        name=TABLE,
        words="the detent torque lags behind the rotor (hysteresis)",
        table=TABLE,
        null="torque",
        free={
            "torque": (Float(0.02) * holding, Integer(0), Float(0.3) * holding),
            "angle_deg": (Float(TYPICAL_ANGLE_DEG), Float(1.0), Float(90.0)),
        },
        tried={"angle_deg": (5.0, TYPICAL_ANGLE_DEG, 45.0)},
    )
