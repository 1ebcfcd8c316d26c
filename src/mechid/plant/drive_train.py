"""Rotor with set-valued friction, gear, and the rigid test mass (RAG and test mass)."""

from __future__ import annotations

from sympy import symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block, Guard, Switch

alpha, omega, alpha_gear, omega_gear = symbols("alpha omega alpha_gear omega_gear")


def rotor() -> Block:
    """Rotor on dry friction: J_rot alpha_ddot = T_res = T_mot - T_fr - T_rg.

    Equations (6) and (8) of [Kornienko2013]_, read as set-valued: the rotor is stuck while
    |T_mot - T_rg| <= T_frs, else T_fr = T_frd sign(omega) + T_visc omega; N m, rad, rad/s.
    `free` is 0 in the stuck mode and 1 in the sliding ones, `sigma` the direction of sliding.
    """
    J_rot, T_frs, T_frd, T_visc, p, theta_0 = symbols("J_rot T_frs T_frd T_visc p theta_0")
    T_mot, T_rg = symbols("T_mot_in T_rg_in")
    drive, T_fr, T_res, free, sigma = symbols("T_drive T_fr T_res free sigma")
    at_rest = {omega: 0.0}
    friction = Switch(
        name="friction",
        modes={
            "stuck": {free: 0.0, sigma: 0.0},
            "forward": {free: 1.0, sigma: 1.0},
            "backward": {free: 1.0, sigma: -1.0},
        },
        guards={
            "stuck": (
                Guard(margin=T_frs - drive, target="forward"),
                Guard(margin=T_frs + drive, target="backward"),
            ),
            "forward": (Guard(margin=omega, resets=at_rest),),
            "backward": (Guard(margin=-omega, resets=at_rest),),
        },
        entry=(
            (omega, "forward"),
            (-omega, "backward"),
            (drive - T_frs, "forward"),
            (-drive - T_frs, "backward"),
        ),
        otherwise="stuck",
        ideal={free: 1.0, sigma: 0.0},
    )
    return Block(
        name="rotor",
        table="friction",
        declarations=(
            Declaration(
                key="stepper.rotor_inertia", symbol="J_rot", unit="kg m2", meaning="rotor inertia", lower=0.0
            ),
            Declaration(key="static", symbol="T_frs", unit="N m", meaning="static friction", lower=0.0,
                        typical=("k_m*U/R", 0.002, 0.1)),
            Declaration(key="coulomb", symbol="T_frd", unit="N m", meaning="Coulomb friction", lower=0.0,
                        typical=("k_m*U/R", 0.002, 0.15)),
            Declaration(key="viscous", symbol="T_visc", unit="N m s/rad", meaning="viscous friction", lower=0.0,
                        typical=("k_m*k_v/R", 0.02, 2.0)),
        ),
        inputs=(T_mot, T_rg),
        terms={
            drive: T_mot - T_rg,
            T_fr: T_frd * sigma + T_visc * omega,
            T_res: free * (drive - T_fr),
        },
        rates={alpha: omega, omega: T_res / J_rot},
        initial={alpha: theta_0 / (p / 2), omega: 0},
        outputs={"alpha": alpha, "omega": omega, "T_res": T_res},
        switch=friction,
    )  # fmt: skip


def gear() -> Block:
    """Gear as spring and damper: T_rg = K_s/G^2 (alpha - G alpha_g) + D/G^2 (omega - G omega_g).

    Equations (7) and (9) of [Kornienko2013]_; K_s in N m/rad and D in N m s/rad at the output, T_rg in N m at
    the rotor, T_applied = G T_rg at the output. The ratio may be negative.
    """
    G, K_s, D, T_rg = symbols("G K_s D T_rg")
    return Block(
        name="gear",
        table="gear",
        declarations=(
            Declaration(key="ratio", symbol="G", unit="1", meaning="transmission ratio", structural=True),
            Declaration(key="stiffness", symbol="K_s", unit="N m/rad", meaning="gear stiffness at output", lower=0.0),
            Declaration(key="damping", symbol="D", unit="N m s/rad", meaning="gear damping at output", lower=0.0),
        ),
        inputs=(alpha, omega, alpha_gear, omega_gear),
        terms={T_rg: K_s / G**2 * (alpha - G * alpha_gear) + D / G**2 * (omega - G * omega_gear)},
        outputs={"T_rg": T_rg, "T_applied": G * T_rg},
    )


def rigid_load() -> Block:
    """Rigid test mass: J_m alpha_g_ddot = T_applied, equation (10) of [Kornienko2013]_; kg m2, rad, N m."""
    J_m, T_applied, G, p, theta_0 = symbols("J_m T_applied_in G p theta_0")
    return Block(
        name="load",
        table="load",
        declarations=(Declaration(key="inertia", symbol="J_m", unit="kg m2", meaning="test mass inertia", lower=0.0),),
        inputs=(T_applied,),
        rates={alpha_gear: omega_gear, omega_gear: T_applied / J_m},
        initial={alpha_gear: theta_0 / (p / 2) / G, omega_gear: 0},
        outputs={"alpha_gear": alpha_gear, "omega_gear": omega_gear},
    )
