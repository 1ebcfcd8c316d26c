"""Rotor of a drive train (RAG), with its friction in a separate block.

On a base that rotates by beta, angles are relative to the base. The torque on a body is then the one that accelerates
it in inertial space, and a body held by friction adds its inertia to the base. The load is in `load`.
"""

from __future__ import annotations

from sympy import Expr, Integer, Symbol, sin, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block
from mechid.plant.ports import PUSH
from mechid.plant.start import ANGLE, FULL_STEP, RATE
from mechid.plant.start import start as own_start

alpha, omega, alpha_gear, omega_gear = symbols("alpha omega alpha_gear omega_gear")
p, theta_0, G = symbols("p theta_0 G")
COMMANDED = theta_0 / (p / 2)
"""Start angle of a stepper's rotor, rad."""
PER_STEP = 1 / (2 * p)
"""Turns of a stepper's rotor per full step."""
INERTIA = Declaration("stepper.rotor_inertia", "J_rot", "kg m2", "rotor inertia", lower=0.0)
beta_acc = Symbol("beta_acc_in")
"""Acceleration of the base, rad/s2."""
SWING = f"{FULL_STEP}*sqrt(T_hold*p/(2*J_rot))"
"""Rate of a rotor that swings by a full step about the detent of one phase, rad/s."""


def rotor(
    *,
    geared: bool = True,
    start: Expr = COMMANDED,
    inertia: Declaration = INERTIA,
    start_rate: Declaration | None = None,
    unbalance: Declaration | None = None,
    turns: bool = False,
    pushed: bool = False,
) -> Block:
    """Rotor: J_rot alpha_ddot = T_res = T_mot - T_fr - T_rg, with - W sin(alpha) if unbalanced.

    Equation (6) of [Kornienko2013]_; N m, rad, rad/s. The friction block supplies T_fr and `free`, which is 0 while
    friction holds the rotor. On a base that rotates, J_rot (alpha_ddot + beta_ddot) = T_res, and at rest friction
    has to hold T_mot - T_rg - J_rot beta_ddot.

    Parameters
    ----------
    geared : bool
        False if the motor alone drives it.
    start : Expr
        Angle at the start of a record, rad.
    inertia : Declaration
        Declaration of J_rot; its key gives the place in the file.
    start_rate : Declaration or None
        Declaration of the speed at the start of a record; None: at rest.
    unbalance : Declaration or None
        Declaration of W = m c g for an axis whose mass hangs at alpha = 0; None: balanced, or along gravity.
    turns : bool
        Whether its base rotates.
    pushed : bool
        Whether an external torque acts on it (`ports`): the base then feels T_reaction = T_res minus that torque.
    """
    T_mot, T_rg, T_fr, free = symbols("T_mot_in T_rg_in T_fr_in free_in")
    drive, T_res, T_reaction, J_rot = symbols(f"T_drive T_res T_reaction {inertia.symbol}")
    driven = T_mot - T_rg if geared else T_mot
    if unbalance:
        driven -= Symbol(unbalance.symbol) * sin(alpha)
    pushing = PUSH if pushed else Integer(0)
    inputs = (T_mot, *([T_rg] if geared else []), T_fr, free, *([PUSH] if pushed else []))
    outputs: dict[str, Expr] = {"alpha": alpha, "omega": omega, "T_res": T_res, "T_drive": drive}
    if turns:
        held = Symbol("beta_acc_rotor_in")
        inputs = (*inputs, beta_acc, held)
        # A rotor held by friction moves with the base: the torque on it accelerates its inertia.
        moving = free * (driven + pushing - T_fr) + (1 - free) * J_rot * beta_acc
        terms = {drive: driven + pushing - J_rot * held, T_res: moving}
        rate: Expr = free * (T_res / J_rot - beta_acc)
        outputs |= {"T_free_rotor": driven - T_fr, "T_held_rotor": -pushing, "I_rotor": J_rot}
    else:
        terms = {drive: driven + pushing, T_res: free * (drive - T_fr)}
        rate = T_res / J_rot
    if pushed:
        # The external torque has no counterpart on the base.
        terms[T_reaction] = T_res - pushing
        outputs["T_res"] = T_reaction
    return Block(
        name="rotor",
        table="rotor",
        declarations=tuple(d for d in (inertia, start_rate, unbalance) if d),
        inputs=inputs,
        terms=terms,
        rates={alpha: omega, omega: rate},
        initial={alpha: start + ANGLE, omega: (Symbol(start_rate.symbol) if start_rate else 0) + RATE},
        starts=(
            own_start("angle", ANGLE, "rad", "angle of the rotor at the start, off the commanded one", FULL_STEP),
            own_start("rate", RATE, "rad/s", "rate of the rotor at the start", SWING),
        ),
        outputs=outputs,
    )
