from sympy import sqrt, symbols

from mechid.parameter import Declaration
from mechid.plant.friction import ROTOR, set_valued


def law():
    T_c, b, omega_g, x, T_drive, t = symbols("T_c b_g omega_g x T_drive t")
    sigma, omega = ROTOR.sigma, ROTOR.omega
    return set_valued(
        ROTOR,
        (
            Declaration(key="dry", symbol="T_c", unit="N m", meaning="dry friction", lower=None, source="a"),
            Declaration(key="grease", symbol="b_g", unit="N m s/rad", meaning="grease at rest", lower=0.0, source="a"),
            Declaration(key="thinning_rate", symbol="omega_g", unit="rad/s", meaning="a speed", lower=0.0, source="a"),
        ),
        sliding=T_c * sigma + b * omega / sqrt(1 + sigma * omega / omega_g),
        holds=(T_c, T_c),
        reference="a",
    )
