"""Brushed DC motor with one winding and a commutator, and a spring from its shaft to the base."""

from __future__ import annotations

from functools import partial

from sympy import Symbol, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block
from mechid.plant.drive_train import alpha, omega

HUGHES = "Hughes, Drury, Electric Motors and Drives"
_parameter = partial(Declaration, source=HUGHES)
SPRING = "spring"
"""Table of the spring at the shaft."""
DAMPING = "k_t*k_e/R"
"""Damping by the shorted winding, in the file's symbols."""
INERTIA = _parameter("motor.inertia", "J_rot", "kg m2", "inertia of the rotor and all on its shaft", lower=0.0)


def dc_winding() -> Block:
    """One winding: L di/dt = u - R i - k_e omega, T_mot = k_t i; i in A, u in V, omega in rad/s, T_mot in N m.

    Hughes and Drury, chapter on DC motors; the commutator is ideal: no ripple, and no voltage drop across the brushes.
    A record begins with the current settled at its first voltage. In SI units k_e = k_t unless the file says otherwise;
    energy balances only then.
    """
    i, u, R, L, k_t, k_e = symbols("i_mot u_mot_in R L k_t k_e")
    return Block(
        name="winding",
        table="motor",
        declarations=(
            _parameter("resistance", R.name, "ohm", "resistance of winding, brushes and leads", lower=0.0, spread=1.25),
            _parameter("inductance", L.name, "H", "inductance of the winding", lower=0.0),
            _parameter("torque_constant", k_t.name, "N m/A", "torque constant", lower=0.0),
            _parameter(
                "back_emf_constant", k_e.name, "V s/rad", "back-EMF constant", lower=0.0, tied_to="torque_constant"
            ),
        ),
        inputs=(u, omega),
        rates={i: (u - R * i - k_e * omega) / L},
        initial={i: u / R},
        outputs={"i": i, "T_mot": k_t * i},
        swinging={i: ""},
        reference=HUGHES,
    )


def shaft_spring() -> Block:
    """Spring from the shaft to the base: T_spring = K (alpha - alpha_0); N m, rad."""
    K, alpha_0, T = Symbol("K_spring"), Symbol("alpha_0"), Symbol("T_spring")
    own, rest = partial(Declaration, source="Hooke's law"), "angle of the shaft at which the spring pulls neither way"
    return Block(
        name=SPRING,
        table=SPRING,
        declarations=(
            own("stiffness", K.name, "N m/rad", "stiffness of the spring from shaft to base", lower=0.0),
            own("rest_angle", alpha_0.name, "rad", rest, default=0.0),
        ),
        terms={T: K * (alpha - alpha_0)},
        outputs={T.name: T},
        reference="Hooke's law",
    )
