"""Error of a driver's microstep table: deviation of the electrical angle from the commanded one."""

from __future__ import annotations

from collections.abc import Sequence

from sympy import Expr, Float, Integer, Symbol, expand, symbols

from mechid.plant.block import Extension
from mechid.plant.harmonic import ListedHarmonic

TABLE = "stepper.microstep_table"
ORDERS = (2, 4)
"""Harmonics of the commanded electrical angle that are tried if the file lacks them."""
HIGHEST = 16
"""Highest order: four periods per full step. The polynomial of a much higher order would lose digits."""
TMC429 = "Trinamic, TMC429 data sheet, v. 1.07 (2012), section 13: microstep look-up table"
e_A, e_B = Symbol("e_A"), Symbol("e_B")
WAVEFORMS = (e_A, e_B)
"""Normalised waveforms of the command."""
GIVEN: tuple[Symbol, Symbol] = (Symbol("given_A"), Symbol("given_B"))
"""Waveforms as output by the driver."""
delta, p = symbols("delta_table p")


def harmonics(orders: Sequence[int]) -> tuple[ListedHarmonic, ...]:
    """Return the error's harmonics over the commanded electrical angle, in rad of that angle."""
    return tuple(
        ListedHarmonic(
            table=TABLE,
            index=index,
            order=order,
            letters=("n_m", "A_m", "phi_m", "c_m", "s_m"),
            unit="rad",
            most=1.0,
            highest=HIGHEST,
            source=TMC429,
            turns=p / 2,
            meanings=(
                "periods of the table's error per electrical period",
                "amplitude of the table's error, of the electrical angle",
                "phase of the table's error",
            ),
        )
        for index, order in enumerate(orders)
    )


def error(orders: Sequence[int]) -> dict[Symbol, Expr]:
    """Return delta = sum A_n sin(n theta + phi_n) and the driver's waveforms, as polynomials of the commanded ones.

    A square wave with both phases fully on comes from no table: there e_A^2 + e_B^2 is 2, else it is 1.
    """
    waves = [(h.parts, _multiple(order)) for h, order in zip(harmonics(orders), orders, strict=True)]
    total = sum((c * sine + s * cosine for (c, s), (cosine, sine) in waves), Integer(0))
    if not orders:
        return {}
    return {delta: (2 - e_A**2 - e_B**2) * total, GIVEN[0]: e_A + delta * e_B, GIVEN[1]: e_B - delta * e_A}


def driver_waveforms(orders: Sequence[int]) -> tuple[Expr, Expr]:
    """Return the driver's waveforms of both phases: -cos(theta) + delta sin(theta), and so on.

    A component of relative size delta is perpendicular to the commanded vector and rotates it by arctan(delta).
    """
    return GIVEN if orders else WAVEFORMS


def extensions(orders: Sequence[int]) -> tuple[Extension, ...]:
    """Return the harmonics that may be added, of 0.03 rad: a third harmonic of 3 % in the table's sine."""
    return tuple(
        Extension(
            name=TABLE,
            words="error of the driver's microstep table",
            table=TABLE,
            order=order,
            structure={"order": Integer(order)},
            widths={"amplitude": Float(0.03)},
            grown=False,
        )
        for order in ORDERS
        if order not in orders
    )


def _multiple(order: int) -> tuple[Expr, Expr]:
    """Return cosine and sine of n theta from the waveforms -e_A = cos(theta) and e_B = sin(theta)."""
    cosine, sine = Integer(1), Integer(0)
    # Powers of cos(theta) + i sin(theta), expanded to polynomials of the waveforms.
    for _ in range(order):
        cosine, sine = expand(-cosine * e_A - sine * e_B), expand(-sine * e_A + cosine * e_B)
    return cosine, sine
