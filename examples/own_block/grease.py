"""A friction law of one's own: viscous friction of a grease that falls with the square root of the speed."""

from sympy import sqrt, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block
from mechid.plant.friction import ROTOR, set_valued


def grease() -> Block:
    """T_fr = T_c sign(omega) + b omega / sqrt(1 + |omega|/omega_g), held up to T_c."""
    T_c, b, omega_g = symbols("T_c b_g omega_g")
    sigma, omega, source = ROTOR.sigma, ROTOR.omega, "grease data sheet"
    return set_valued(
        ROTOR,
        (
            Declaration("dry", "T_c", "N m", "dry friction", lower=0.0, source=source),
            Declaration("grease", "b_g", "N m s/rad", "grease at rest", lower=0.0, source=source),
            Declaration("thinning_rate", "omega_g", "rad/s", "speed at which it has thinned", lower=0.0, source=source),
        ),
        sliding=T_c * sigma + b * omega / sqrt(1 + sigma * omega / omega_g),
        holds=(T_c, T_c),
        reference=source,
    )
