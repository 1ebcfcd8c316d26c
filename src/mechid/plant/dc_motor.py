"""Brushed DC motor: one winding behind a commutator; and a spring that holds its shaft to the base."""

from __future__ import annotations

from sympy import Symbol, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block
from mechid.plant.drive_train import alpha, omega

HUGHES = "Hughes, Drury, Electric Motors and Drives"
SPRING = "spring"
"""Table of the spring at the shaft."""
DAMPING = "k_t*k_e/R"
"""Damping by the shorted winding, in the file's symbols."""
INERTIA = Declaration(
    key="motor.inertia",
    symbol="J_rot",
    unit="kg m2",
    lower=0.0,
    source=HUGHES,
    meaning="inertia of the rotor and all on its shaft",
)


def dc_winding() -> Block:
    """One winding: L di/dt = u - R i - k_e omega, T_mot = k_t i; i in A, u in V, omega in rad/s, T_mot in N m.

    Hughes and Drury, chapter on DC motors; the commutator is ideal: no ripple, and no voltage across the brushes. A
    record begins with the current settled at its first voltage. In SI units k_e = k_t unless the file says otherwise:
    then energy balances.
    """
    i, u, R, L, k_t, k_e = symbols("i_mot u_mot_in R L k_t k_e")
    return Block(
        name="winding",
        table="motor",
        declarations=(
            Declaration(key="resistance", symbol=R.name, unit="ohm", lower=0.0, spread=1.25, source=HUGHES,
                        meaning="resistance of winding, brushes and leads"),
            Declaration(key="inductance", symbol=L.name, unit="H", lower=0.0, source=HUGHES,
                        meaning="inductance of the winding"),
            Declaration(key="torque_constant", symbol=k_t.name, unit="N m/A", lower=0.0, source=HUGHES,
                        meaning="torque constant"),
            Declaration(key="back_emf_constant", symbol=k_e.name, unit="V s/rad", lower=0.0, source=HUGHES,
                        tied_to="torque_constant", meaning="back-EMF constant"),
        ),
        inputs=(u, omega),
        rates={i: (u - R * i - k_e * omega) / L},
        initial={i: u / R},
        outputs={"i": i, "T_mot": k_t * i},
        swinging={i: ""},
        reference=HUGHES,
    )  # fmt: skip


def shaft_spring() -> Block:
    """Spring from the shaft to the base: T_spring = K (alpha - alpha_0); N m, rad."""
    K, alpha_0, T = Symbol("K_spring"), Symbol("alpha_0"), Symbol("T_spring")
    return Block(
        name=SPRING,
        table=SPRING,
        declarations=(
            Declaration(key="stiffness", symbol=K.name, unit="N m/rad", lower=0.0, source="Hooke's law",
                        meaning="stiffness of the spring from shaft to base"),
            Declaration(key="rest_angle", symbol=alpha_0.name, unit="rad", default=0.0, source="Hooke's law",
                        meaning="angle of the shaft at which the spring pulls neither way"),
        ),
        terms={T: K * (alpha - alpha_0)},
        outputs={T.name: T},
        reference="Hooke's law",
    )  # fmt: skip
