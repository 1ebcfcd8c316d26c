"""The rotor's magnet over temperature: its flux, and with it the detent torque, falls as it gets warm.

T_D(dT) = T_D (1 + c dT), dT the motor's temperature above that of the file's values.
"""

from __future__ import annotations

from sympy import symbols

from mechid.parameter import Declaration, Role
from mechid.plant.block import Block

TABLE = "stepper.magnet"
RISE = "temperature_rise"
CAMPBELL = "Campbell, Permanent Magnet Materials and their Application (1994), chapter 3"
factor = symbols("detent_factor")


def magnet() -> Block:
    """Return the factor of the detent torque over temperature: 1 + c dT, c in 1/K, dT in K."""
    c, rise = symbols("c_detent dT_motor")
    return Block(
        name="magnet",
        table=TABLE,
        declarations=(
            Declaration(
                RISE,
                rise.name,
                "K",
                "temperature of the motor above that of the file's values",
                lower=-300.0,
                upper=300.0,
                default=0.0,
                role=Role.TEMPERATURE,
                source=CAMPBELL,
            ),
            Declaration(
                "detent_per_K",
                c.name,
                "1/K",
                "change of the detent torque with temperature, over its value",
                lower=-0.02,
                upper=0.02,
                source=CAMPBELL,
            ),
        ),
        outputs={factor.name: 1 + c * rise},
        reference=CAMPBELL,
    )
