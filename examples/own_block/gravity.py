"""An unbalanced output: the load of a pendulum, written as a block of one's own."""

from sympy import sin, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block


def unbalanced_load() -> Block:
    """Load with its centre of mass off the axis: J_m a'' = T_applied - m c g sin(a), as a pendulum hangs."""
    a, v, T, J, W, G, p, theta_0 = symbols("alpha_gear omega_gear T_applied_in J_m W_u G p theta_0")
    book = "Goldstein, Classical Mechanics"
    return Block(
        name="unbalanced_load",
        table="load",
        declarations=(
            Declaration("inertia", "J_m", "kg m2", "inertia of the load", lower=0.0, source=book),
            Declaration("unbalance", "W_u", "N m", "m c g of the load", lower=0.0, source=book),
        ),
        inputs=(T,),
        rates={a: v, v: (T - W * sin(a)) / J},
        initial={a: theta_0 / (p / 2) / G, v: 0},
        outputs={"alpha_gear": a, "omega_gear": v, "T_load": T},
    )
