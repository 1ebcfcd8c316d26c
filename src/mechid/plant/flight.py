"""The mechanism in flight: on a structure's modes instead of a bench, with a load that may be flexible.

Angles of rotor and load are relative to the base, which turns by beta. With the modes of the structure in
mass-normalised form, beta = sum phi_k eta_k and eta_k_ddot = phi_k T_base - 2 zeta_k w_k eta_k_dot - w_k^2 eta_k:

    J_rot (alpha_ddot + beta_ddot) = T_res = T_mot - T_fr - T_rg,
    T_base = -(T_res + G T_rg),
    beta_ddot = s + S T_base,   s = -sum phi_k (2 zeta_k w_k eta_k_dot + w_k^2 eta_k),   S = sum phi_k^2

The paper's housing filter has no reaction on the mechanism and stays on the bench.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import sympy as sp
from sympy import symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block
from mechid.plant.drive import voltage_drive
from mechid.plant.drive_train import alpha_gear, load, omega, omega_gear, rotor
from mechid.plant.friction import ROTOR, coulomb
from mechid.plant.gear import gear
from mechid.plant.housing import rigid_housing
from mechid.plant.plant import Plant, assemble
from mechid.plant.stepper import detent, motor_torque, windings
from mechid.plant.test_stand import base_torque

NAME = "stepper_gear_mass_in_flight"


def in_flight(detent_orders: Sequence[int | None], base_modes: int, load_modes: int) -> Plant:
    """Return the paper's mechanism, its base on `base_modes` modes and `load_modes` cantilever modes in its load.

    Without base modes the base is held: its torque is the blocked one.
    """
    return _in_flight(tuple(detent_orders), base_modes, load_modes)


@lru_cache(maxsize=32)
def _in_flight(detent_orders: tuple[int | None, ...], base_modes: int, load_modes: int) -> Plant:
    detents = [detent(k, order) for k, order in enumerate(detent_orders)]
    moving = [rotor_on_base(), base(base_modes)] if base_modes else [rotor()]
    blocks: list[Block] = [
        voltage_drive(), windings(), *detents, motor_torque(len(detents)), *moving, coulomb(ROTOR),
        gear(), flight_load(load_modes, on_base=base_modes > 0), rigid_housing(), base_torque(),
    ]  # fmt: skip
    return assemble(NAME, blocks, {}, {"torque": "transducer.T_base"})


def base(modes: int) -> Block:
    """Modes of the structure at the interface, driven by the torque on the base."""
    s, T_base, beta_acc, T_res, T_applied = symbols("s_base T_base beta_acc T_res_in T_applied_in")
    etas = [symbols(f"eta_{k} eta_dot_{k}") for k in range(modes)]
    values = [symbols(f"omega_base_{k} zeta_base_{k} phi_base_{k}") for k in range(modes)]
    held = [2 * zeta * w * v + w**2 * eta for (eta, v), (w, zeta, _) in zip(etas, values, strict=True)]
    S = sum((phi**2 for _, _, phi in values), sp.Integer(0))
    rates: dict[sp.Symbol, sp.Expr] = {}
    for (eta, v), (_, _, phi), spring in zip(etas, values, held, strict=True):
        rates |= {eta: v, v: phi * T_base - spring}
    return Block(
        name="base",
        table="base",
        declarations=tuple(d for k in range(modes) for d in _base_mode(k)),
        inputs=(T_res, T_applied),
        terms={
            s: -sum((phi * spring for (_, _, phi), spring in zip(values, held, strict=True)), sp.Integer(0)),
            T_base: -(T_res + T_applied),
            beta_acc: s + S * T_base,
        },
        rates=rates,
        initial=dict.fromkeys(rates, sp.Integer(0)),
        outputs={"s_base": s, "S_base": S, "beta_acc": beta_acc},
        reference="",
    )


def rotor_on_base() -> Block:
    """Rotor whose base accelerates: while it is stuck, friction carries J_rot beta_ddot too.

    Stuck, T_res = J_rot beta_ddot, so that beta_ddot = (s - S G T_rg)/(1 + S J_rot).
    """
    plain = rotor()
    G, J_rot = symbols("G J_rot")
    s, S, beta_acc = symbols("s_base_in S_base_in beta_acc_in")
    T_mot, T_rg, T_fr, free = plain.inputs
    drive, T_res, stuck = symbols("T_drive T_res beta_acc_stuck")
    terms = {
        stuck: (s - S * G * T_rg) / (1 + S * J_rot),
        drive: T_mot - T_rg - J_rot * stuck,
        T_res: free * (T_mot - T_rg - T_fr) + (1 - free) * J_rot * stuck,
    }
    return replace(
        plain,
        inputs=(*plain.inputs, s, S, beta_acc),
        terms=terms,
        rates={**plain.rates, omega: free * (T_res / J_rot - beta_acc)},
        reference="",
    )


def flight_load(modes: int, *, on_base: bool) -> Block:
    """Load of inertia J_m in all, with cantilever modes of participation p_k (p_k^2 their effective inertia).

    With A the hub's acceleration in inertial space,
    (J_m - sum p_k^2) A = G T_rg + sum p_k (2 zeta_k w_k q_k_dot + w_k^2 q_k),
    q_k_ddot = -p_k A - 2 zeta_k w_k q_k_dot - w_k^2 q_k.
    """
    plain = load()
    J_m, T_applied, A, beta_acc = symbols("J_m T_applied_in A_load beta_acc_in")
    states = [symbols(f"q_{k} q_dot_{k}") for k in range(modes)]
    values = [symbols(f"omega_load_{k} zeta_load_{k} p_load_{k}") for k in range(modes)]
    held = [2 * zeta * w * v + w**2 * q for (q, v), (w, zeta, _) in zip(states, values, strict=True)]
    springs = sum((p * h for (_, _, p), h in zip(values, held, strict=True)), sp.Integer(0))
    rigid = J_m - sum((p**2 for _, _, p in values), sp.Integer(0))
    rates = {alpha_gear: omega_gear, omega_gear: A - (beta_acc if on_base else 0)}
    for (q, v), (_, _, p), spring in zip(states, values, held, strict=True):
        rates |= {q: v, v: -p * A - spring}
    return replace(
        plain,
        declarations=(*plain.declarations, *(d for k in range(modes) for d in _load_mode(k))),
        inputs=(T_applied, beta_acc) if on_base else (T_applied,),
        terms={A: (T_applied + springs) / rigid},
        rates=rates,
        initial={**plain.initial, **{x: sp.Integer(0) for pair in states for x in pair}},
        reference="",
    )


def _base_mode(k: int) -> tuple[Declaration, ...]:
    return _mode("base", k, "phi", "rad/(kg^0.5 m)", "rotation of the interface in")


def _load_mode(k: int) -> tuple[Declaration, ...]:
    return _mode("load", k, "p", "kg^0.5 m", "participation in the hub's rotation of")


def _mode(which: str, k: int, shape: str, unit: str, meaning: str) -> tuple[Declaration, ...]:
    of = f"mode {k} of the {which}"
    return (
        Declaration(key=f"{which}.{k}.frequency", symbol=f"omega_{which}_{k}", unit="rad/s",
                    meaning=f"frequency of {of}", lower=0.0, source=""),
        Declaration(key=f"{which}.{k}.damping", symbol=f"zeta_{which}_{k}", unit="1", meaning=f"damping of {of}",
                    lower=0.0, source=""),
        Declaration(key=f"{which}.{k}.shape", symbol=f"{shape}_{which}_{k}", unit=unit, meaning=f"{meaning} {of}",
                    source=""),
    )  # fmt: skip
