"""Rotor and load of a drive train (RAG and test mass): bodies whose friction is a block of its own.

On a base that turns by beta, angles are relative to it. A body's torque is then what turns it in inertial space, and
while friction holds a body it carries its inertia along with the base.
"""

from __future__ import annotations

from sympy import Expr, Integer, Symbol, sin, symbols

from mechid.parameter import Declaration, Role
from mechid.plant.block import Block

alpha, omega, alpha_gear, omega_gear = symbols("alpha omega alpha_gear omega_gear")
p, theta_0, G = symbols("p theta_0 G")
COMMANDED = theta_0 / (p / 2)
"""Angle in rad at which a stepper's rotor starts."""
INERTIA = Declaration(key="stepper.rotor_inertia", symbol="J_rot", unit="kg m2", meaning="rotor inertia", lower=0.0)
LOAD_ON_GEAR = "load on the gear"
beta_acc = Symbol("beta_acc_in")
"""Acceleration of the base, rad/s2."""


def rotor(
    *,
    geared: bool = True,
    start: Expr = COMMANDED,
    inertia: Declaration = INERTIA,
    start_rate: Declaration | None = None,
    unbalance: Declaration | None = None,
    turns: bool = False,
) -> Block:
    """Rotor: J_rot alpha_ddot = T_res = T_mot - T_fr - T_rg, and - W sin(alpha) where it is unbalanced.

    Equation (6) of [Kornienko2013]_; N m, rad, rad/s. The friction block beside it gives T_fr, and `free`, which
    is 0 while it holds the rotor. On a base that turns, J_rot (alpha_ddot + beta_ddot) = T_res, and at rest friction
    has to hold T_mot - T_rg - J_rot beta_ddot.

    Parameters
    ----------
    geared : bool
        False: nothing but the motor drives it.
    start : Expr
        Angle at the start of a record, rad.
    inertia : Declaration
        Of J_rot; its key says where in the file it stands.
    start_rate : Declaration or None
        Of the speed at the start of a record; None: at rest.
    unbalance : Declaration or None
        Of W = m c g, of an axis that hangs at alpha = 0; None: balanced, or across gravity.
    turns : bool
        Whether its base turns.
    """
    T_mot, T_rg, T_fr, free = symbols("T_mot_in T_rg_in T_fr_in free_in")
    drive, T_res, J_rot = symbols(f"T_drive T_res {inertia.symbol}")
    driven = T_mot - T_rg if geared else T_mot
    if unbalance:
        driven -= Symbol(unbalance.symbol) * sin(alpha)
    inputs = (T_mot, *([T_rg] if geared else []), T_fr, free)
    outputs: dict[str, Expr] = {"alpha": alpha, "omega": omega, "T_res": T_res, "T_drive": drive}
    if turns:
        held = Symbol("beta_acc_rotor_in")
        inputs = (*inputs, beta_acc, held)
        terms = {drive: driven - J_rot * held, T_res: free * (driven - T_fr) + (1 - free) * J_rot * beta_acc}
        rate: Expr = free * (T_res / J_rot - beta_acc)
        outputs |= {"T_free_rotor": driven - T_fr, "T_held_rotor": Integer(0), "I_rotor": J_rot}
    else:
        terms = {drive: driven, T_res: free * (drive - T_fr)}
        rate = T_res / J_rot
    return Block(
        name="rotor",
        table="rotor",
        declarations=tuple(d for d in (inertia, start_rate, unbalance) if d),
        inputs=inputs,
        terms=terms,
        rates={alpha: omega, omega: rate},
        initial={alpha: start, omega: Symbol(start_rate.symbol) if start_rate else 0},
        outputs=outputs,
    )


def load(*, modes: int = 0, rubbed: bool = False, start: Expr = COMMANDED, turns: bool = False) -> Block:
    """Load on the output, rigid or with flexible modes, free or with friction of its own.

    Rigid and free it is the paper's test mass, J_m alpha_g_ddot = T_applied, equation (10) of [Kornienko2013]_;
    kg m2, rad, N m. Each mode k, seen from the output, is an inertia J_k on a spring, q_k its deflection:

        q_k'' + 2 zeta_k omega_k q_k' + omega_k^2 q_k = -A
        (J_m - sum J_k) A = T_applied + sum J_k (omega_k^2 q_k + 2 zeta_k omega_k q_k') - T_fr

    (cantilever modes with effective inertias J_k; J_m is the inertia of the whole; A = alpha_g'' is the hub's
    acceleration, on a base that turns alpha_g'' + beta''). The base feels T_load = T_applied - T_fr.

    Parameters
    ----------
    modes : int
    rubbed : bool
        Whether a friction block acts on it.
    start : Expr
        The rotor's angle at the start of a record, rad.
    turns : bool
        Whether its base turns.
    """
    J_m, T_applied, T_fr, free = symbols("J_m T_applied_in T_fr_out_in free_out_in")
    swinging = {alpha_gear: LOAD_ON_GEAR, omega_gear: LOAD_ON_GEAR}
    declared = [
        Declaration(key="inertia", symbol="J_m", unit="kg m2", meaning="test mass inertia", lower=0.0,
                    role=Role.LOAD_INERTIA)
    ]  # fmt: skip
    terms: dict[Symbol, Expr] = {}
    springs: Expr = Integer(0)
    hub = J_m
    rates: dict[Symbol, Expr] = {}
    initial: dict[Symbol, Expr] = {}
    for k in range(1, modes + 1):
        J_k, zeta_k, omega_k, q_k, v_k, spring = symbols(f"J_{k} zeta_{k} omega_{k} q_{k} v_{k} T_mode{k}")
        terms[spring] = J_k * (omega_k**2 * q_k + 2 * zeta_k * omega_k * v_k)
        springs, hub = springs + spring, hub - J_k
        rates |= {q_k: v_k, v_k: -spring / J_k}
        initial |= {q_k: 0, v_k: 0}
        swinging |= dict.fromkeys((q_k, v_k), f"load mode {k}")
        declared += _mode_declarations(k)
    drive, T_load, a_gear = symbols("T_drive_out T_load a_gear")
    inputs = (T_applied, *([T_fr, free] if rubbed else []))
    outputs: dict[str, Expr] = {"alpha_gear": alpha_gear, "omega_gear": omega_gear}
    if modes or rubbed or turns:
        driven = T_applied + springs
        held = hub * Symbol("beta_acc_load_in") if turns and rubbed else Integer(0)
        terms[drive] = driven - held
        moving: Expr = drive + held
        if rubbed:
            moving = free * (drive + held - T_fr) + ((1 - free) * hub * beta_acc if turns else 0)
        terms |= {a_gear: moving / hub, T_load: moving - springs}
        rates |= {v: rate - a_gear for v, rate in rates.items() if v.name.startswith("v_")}
        own = {omega_gear: _relative(a_gear, free, rubbed=rubbed) if turns else a_gear}
        outputs |= {"T_drive_out": drive, "T_load": T_load}
    else:
        own = {omega_gear: T_applied / J_m}
        outputs |= {"T_load": T_applied}
    if turns:
        inputs = (*inputs, beta_acc, *([Symbol("beta_acc_load_in")] if rubbed else []))
        outputs |= {"T_free_load": T_applied - (T_fr if rubbed else 0), "T_held_load": -springs, "I_load": hub}
    return Block(
        name="load",
        table="load",
        declarations=tuple(declared),
        inputs=inputs,
        terms=terms,
        rates={alpha_gear: omega_gear, **own, **rates},
        initial={alpha_gear: start / G, omega_gear: 0, **initial},
        outputs=outputs,
        swinging=swinging,
    )


def _relative(a_gear: Expr, free: Symbol, *, rubbed: bool) -> Expr:
    """Return the hub's acceleration against its base; none while friction holds it."""
    return free * (a_gear - beta_acc) if rubbed else a_gear - beta_acc


def _mode_declarations(k: int) -> list[Declaration]:
    where, source = f"load.mode.{k - 1}", "Craig, Bampton, AIAA J. 6 (1968) 1313-1319"
    return [
        Declaration(key=f"{where}.frequency", symbol=f"omega_{k}", unit="rad/s", lower=0.0, source=source,
                    meaning="cantilever frequency of a flexible mode"),
        Declaration(key=f"{where}.damping", symbol=f"zeta_{k}", unit="1", lower=0.0, source=source,
                    meaning="damping ratio of a flexible mode"),
        Declaration(key=f"{where}.inertia", symbol=f"J_{k}", unit="kg m2", lower=0.0, source=source,
                    meaning="effective inertia of a flexible mode, part of the load's", part_of="load.inertia"),
    ]  # fmt: skip
