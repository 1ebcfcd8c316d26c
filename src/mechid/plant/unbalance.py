"""Weight of a load whose centre of mass is off the output axis, on a bench whose axis is not vertical."""

from __future__ import annotations

from functools import partial

from sympy import Integer, cos, pi, sin, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block, PolarPair
from mechid.plant.drive_train import G, alpha_gear

TABLE = "load.unbalance"
GOLDSTEIN = "Goldstein, Poole, Safko, Classical Mechanics, 3rd ed. (2002)"
_parameter = partial(Declaration, source=GOLDSTEIN)


def unbalance() -> Block:
    """Torque of the weight, T_unbalance = W sin(alpha_gear + phi_u), against which the load is moved; N m, rad.

    W = m g r sin(i), with r the distance of the centre of mass from the axis and i the angle between the axis and the
    vertical; the centre of mass is lowest at alpha_gear = -phi_u. The weight is an external torque: the transducer
    under the mechanism measures it like the torque that accelerates the load.
    """
    W, phi, W_c, W_s, T = symbols("W_u phi_u W_c W_s T_unbalance")
    turned = phi * pi / 180
    return Block(
        name="unbalance",
        table=TABLE,
        declarations=(
            _parameter(
                "amplitude", W.name, "N m", "greatest torque of the load's weight about the output axis", lower=0.0
            ),
            _parameter(
                key="phase_deg",
                symbol=phi.name,
                unit="deg",
                meaning="angle of the load from where its centre of mass hangs lowest to its zero",
                default=0.0,
            ),
        ),
        coordinates={W_c: W * cos(turned), W_s: W * sin(turned)},
        # Cycles count per turn of the rotor, not of the load.
        polar=(PolarPair(amplitude="amplitude", phase="phase_deg", cosine=W_c, sine=W_s, cycles=Integer(1) / G),),
        terms={T: W_c * sin(alpha_gear) + W_s * cos(alpha_gear)},
        outputs={T.name: T},
        reference=GOLDSTEIN,
    )
