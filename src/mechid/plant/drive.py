"""Voltage drive (VST): the commanded waveform becomes phase voltages."""

from __future__ import annotations

from sympy import symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block


def voltage_drive() -> Block:
    """Ideal voltage source without current control: u_A = U e_A, u_B = U e_B.

    The normalised waveforms e_A = -cos(theta_k), e_B = sin(theta_k) come from the command and are
    held from step to step; u in V. Section 3.1 of [Kornienko2013]_.
    """
    U, e_A, e_B = symbols("U e_A e_B")
    u_A, u_B = symbols("u_A u_B")
    return Block(
        name="drive",
        table="stepper",
        declarations=(
            Declaration(
                key="peak_voltage",
                symbol="U",
                unit="V",
                meaning="peak phase voltage",
                lower=0.0,
                source="not in the paper; 0.6 A x 9.5 ohm comes near its amplitudes",
            ),
        ),
        inputs=(e_A, e_B),
        terms={u_A: U * e_A, u_B: U * e_B},
        outputs={"u_A": u_A, "u_B": u_B},
    )
