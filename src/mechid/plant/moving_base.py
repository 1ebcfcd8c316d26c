"""Base of a mechanism in flight: driven, or on the modes of a structure.

Angles of rotor and load are relative to the base, which rotates by beta. Each body on it exerts the torque by which it
is accelerated in inertial space: T_free while free, T_held + I beta_ddot while friction holds it, since it then moves
with the base. With the modes of the structure in mass-normalised form, beta = sum phi_k eta_k,

    eta_k_ddot = phi_k T_base - 2 zeta_k w_k eta_k_dot - w_k^2 eta_k,
    T_base = -sum (T_free, or T_held + I beta_ddot),
    beta_ddot = (s - S sum (free T_free + (1 - free) T_held)) / (1 + S sum (1 - free) I),
    s = -sum phi_k (2 zeta_k w_k eta_k_dot + w_k^2 eta_k),   S = sum phi_k^2
"""

from __future__ import annotations

from collections.abc import Mapping

from sympy import Expr, Integer, Symbol, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block

Bodies = Mapping[str, str]
"""Bodies on the base, each with the friction output that is 0 while it is held; empty if no friction holds it."""
EWINS = "Ewins, Modal Testing, 2nd ed. (2000)"
ACCELERATION = Symbol("base_acceleration")
"""Acceleration of a driven base, rad/s2: an input of the plant."""


def driven_base(bodies: Bodies) -> Block:
    """Return a base with a prescribed acceleration: beta_ddot is an input of the plant, rad/s2."""
    return Block(
        name="base",
        table="base",
        inputs=(ACCELERATION,),
        outputs={"beta_acc": ACCELERATION, **{f"beta_acc_{body}": ACCELERATION for body in bodies}},
        reference=EWINS,
    )


def base_on_modes(modes: int, bodies: Bodies) -> Block:
    """Modes of the structure at the interface, driven by the torque on the base; see the module.

    `beta_acc_<body>` is the acceleration that the base would have if friction held that body.
    """
    s, beta_acc, T_base = symbols("s_base beta_acc T_base_in")
    etas = [symbols(f"eta_{k} eta_dot_{k}") for k in range(modes)]
    values = [symbols(f"omega_base_{k} zeta_base_{k} phi_base_{k}") for k in range(modes)]
    held = [2 * zeta * w * v + w**2 * eta for (eta, v), (w, zeta, _) in zip(etas, values, strict=True)]
    S = sum((phi**2 for _, _, phi in values), Integer(0))
    rates: dict[Symbol, Expr] = {}
    for (eta, v), (_, _, phi), spring in zip(etas, values, held, strict=True):
        rates |= {eta: v, v: phi * T_base - spring}
    may_hold = {body: Symbol(f"{free}_in") for body, free in bodies.items() if free}
    carried = {body: Symbol(f"beta_acc_{body}") for body in may_hold}
    return Block(
        name="base",
        table="base",
        declarations=tuple(d for k in range(modes) for d in _mode(k)),
        inputs=(T_base, *may_hold.values(), *(i for body in bodies for i in _inputs(body))),
        terms={
            s: -sum((phi * spring for (_, _, phi), spring in zip(values, held, strict=True)), Integer(0)),
            beta_acc: _acceleration(s, S, bodies),
            # `free` is 0 while friction holds a body.
            **{carried[body]: _acceleration(s, S, bodies).subs(free, 0) for body, free in may_hold.items()},
        },
        rates=rates,
        initial=dict.fromkeys(rates, Integer(0)),
        outputs={"beta_acc": beta_acc, **{symbol.name: symbol for symbol in carried.values()}},
        reference=EWINS,
    )


def _inputs(body: str) -> tuple[Symbol, ...]:
    return Symbol(f"T_free_{body}_in"), Symbol(f"T_held_{body}_in"), Symbol(f"I_{body}_in")


def _acceleration(s: Symbol, S: Expr, bodies: Bodies) -> Expr:
    torque, inertia = Integer(0), Integer(0)
    for body, name in bodies.items():
        T_free, T_held, moment = _inputs(body)
        free = Symbol(f"{name}_in") if name else Integer(1)
        torque += free * T_free + (1 - free) * T_held
        # A held body adds its inertia to the base; a free one only reacts with its torque.
        inertia += (1 - free) * moment
    return (s - S * torque) / (1 + S * inertia)


def _mode(k: int) -> tuple[Declaration, ...]:
    of = f"mode {k} of the structure"
    return (
        Declaration(f"base.{k}.frequency", f"omega_base_{k}", "rad/s", f"frequency of {of}", lower=0.0, source=EWINS),
        Declaration(f"base.{k}.damping", f"zeta_base_{k}", "1", f"damping of {of}", lower=0.0, source=EWINS),
        Declaration(
            f"base.{k}.shape", f"phi_base_{k}", "rad/(kg^0.5 m)", f"rotation of the interface in {of}", source=EWINS
        ),
    )
