from sympy import sin, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block


def law():
    a, v, T, J, W, G, p, theta_0, x, omega = symbols("alpha_gear omega_gear T_applied_in J_m W_u G p theta_0 x omega")
    return Block(
        name="unbalanced_load",
        table="load",
        declarations=(
            Declaration(key="inertia", symbol="J_m", unit="kg m2", meaning="inertia", lower=0.0, source="a"),
            Declaration(key="unbalance", symbol="W_u", unit="N m", meaning="m c g", lower=0.0, source="a"),
        ),
        inputs=(T,),
        rates={a: v, v: (T - W * sin(a)) / J},
        initial={a: 0},
        outputs={"alpha_gear": a, "omega_gear": v, "T_load": T},
    )
