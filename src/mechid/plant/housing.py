"""Flexible housing between the rotor's reaction and the torque transducer (section 5.3)."""

from __future__ import annotations

from sympy import Expr, Float, Matrix, Symbol, symbols

from mechid.errors import InputFileError, did_you_mean
from mechid.parameter import Declaration
from mechid.plant.block import Block, LinearSystem, Rival
from mechid.plant.start import start as own_start

FORMS = ("paper", "unit_dc")
FAST = 1500.0
"""A resonance of housing or test stand this low in rad/s is 240 Hz: the number may well be meant in hertz."""


def housing(form: str) -> Block:
    """One resonance on the residual torque: z_ddot + 2 zeta w0 z_dot + w0^2 z = K_res w0^2 T_res.

    Section 5.3 of [Kornienko2013]_, whose numerator is lost; z in N m. The second state is z_dot/w0,
    so that both are of one size. Form ``"paper"``: the transducer sees z (its static gain K_res
    breaks the momentum balance at low frequency). Form ``"unit_dc"``: it sees
    T_res (1 + K s^2/(s^2 + 2 zeta w0 s + w0^2)), of static gain 1.

    Raises
    ------
    InputFileError
        If `form` is neither.
    """
    if form not in FORMS:
        hint = did_you_mean(form, FORMS) or f"; known: {', '.join(FORMS)}"
        raise InputFileError(f'housing.form: unknown form "{form}"{hint}')
    z, v_z, T_res, K_res, omega_0, zeta = symbols("z v_z T_res_in K_res omega_0 zeta")
    gain = K_res if form == "paper" else 1
    seen: Expr = z if form == "paper" else (1 + K_res) * T_res - K_res * (z + 2 * zeta * v_z)
    return Block(
        name="housing",
        table="housing",
        declarations=(
            Declaration(key="gain", symbol="K_res", unit="1", meaning="housing resonance factor", lower=0.0),
            Declaration(
                key="frequency",
                symbol="omega_0",
                unit="rad/s",
                meaning="housing resonance frequency",
                lower=0.0,
                hertz_below=FAST,
            ),
            Declaration(key="damping", symbol="zeta", unit="1", meaning="housing damping ratio", lower=0.0),
        ),
        inputs=(T_res,),
        outputs={"T_residual": seen},
        initial={z: Symbol("z_start"), v_z: Symbol("v_z_start")},
        starts=(
            own_start("housing", Symbol("z_start"), "N m", "torque of the housing's mode at the start", "T_hold*K_res"),
            own_start(
                "housing_rate", Symbol("v_z_start"), "N m", "its rate at the start over its frequency", "T_hold*K_res"
            ),
        ),
        filter=LinearSystem(
            states=(z, v_z),
            inputs=(T_res,),
            A=omega_0 * Matrix([[0, 1], [-1, -2 * zeta]]),
            B=omega_0 * Matrix([[0], [gain]]),
        ),
    )


def rigid_housing() -> Block:
    """No resonance: the transducer sees the residual torque itself; N m."""
    (T_res,) = symbols("T_res_in,")
    resonance = Rival(
        name="housing", words="resonance of the housing", table="housing", law=FORMS[0],
        free={"gain": (Float(2.0), Float(0.05), Float(20.0)), "damping": (Float(0.05), Float(0.005), Float(0.5)),
              "frequency": (Float(5000.0), Float(500.0), Float(20000.0))},
    )  # fmt: skip
    return Block(name="housing", table="housing", inputs=(T_res,), outputs={"T_residual": T_res}, rivals=(resonance,))
