"""Phases of a stepper: their number, their connection, and the two axes that represent three phases in star.

Without a neutral wire the three currents of a star add to zero, so two of them describe the motor. The transform of
Clarke maps the phases X = A, B, C at shift_X = 0, 120 and 240 deg to an axis A along phase A and an axis B 90 deg on:
v_A = 2/3 sum v_X cos(shift_X), v_B = 2/3 sum v_X sin(shift_X). The amplitudes stay, so R, L, k_v and U are those of a
phase; the torque of the axes is 3/2 times that of two phases.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from sympy import Expr, Integer, Rational, Symbol, pi, sqrt

from mechid.errors import InputFileError
from mechid.plant import current_limit, microstep_table, saliency
from mechid.plant.harmonic import ListedHarmonic

TABLE = "stepper"
KEY, CONNECTION = "phases", "connection"
CONNECTIONS: Mapping[int, str] = {2: "bipolar", 3: "star", 4: "unipolar"}
"""Connection of a motor by its number of phases."""
STAR = 3
FULL_STEPS: Mapping[int, int] = {2: 4, 3: 6, 4: 4}
"""Full steps in an electrical period by number of phases."""
TWO_PHASES_ONLY = ("stepper.imbalance", saliency.TABLE, current_limit.TABLE, microstep_table.TABLE)
"""Tables whose equations hold phase by phase, at right angles."""
HARMONIC = "stepper.torque_harmonic"
SCALES: Mapping[str, tuple[str | None, str | None]] = {
    "voltage": ("k_m*U/R", "k_m*k_v/R"),
    "current": ("k_m*I_peak", None),
}
"""Holding torque and electrical damping of a motor with two phases in the file's symbols, by drive."""


def check_star(phases: int, tables: Collection[str]) -> None:
    """Refuse tables that a motor with three phases in star cannot have.

    Raises
    ------
    InputFileError
        One of `tables` describes two phases at right angles.
    """
    if phases == STAR and (wrong := next((name for name in TWO_PHASES_ONLY if name in tables), None)):
        raise InputFileError(f"{wrong}: is of two phases at right angles, {TABLE}.{KEY} = {STAR}; delete the table")


def torque_share(phases: int) -> Expr:
    """Return the torque of a motor's two axes over that of two phases with its constants."""
    return Rational(3, 2) if phases == STAR else Integer(1)


def scales_of(drive: str, phases: int) -> tuple[str | None, str | None]:
    """Return holding torque and electrical damping of a motor in the file's symbols, None where not known."""
    holding, damping = SCALES.get(drive, (None, None))
    if phases != STAR:
        return holding, damping
    return holding and f"3/2*{holding}", damping and f"3/2*{damping}"


def harmonic_of_axis(harmonic: ListedHarmonic, axis: str, angle: Expr, phases: int) -> Expr:
    """Return a harmonic of the torque constant as seen along an axis, at the axis's electrical angle in rad.

    In star the transform leaves sin(h x + phi) along axis A. Along axis B it is 90 deg further on for h = 1, 4, 7, ...,
    and 90 deg back for h = 2, 5, 8, ..., since the wave of these runs from phase to phase the other way.

    Raises
    ------
    InputFileError
        The order is a multiple of three in star, whose phases then cancel.
    """
    order = harmonic.order
    if phases != STAR or order is None:
        return harmonic.over(angle)
    if order % 3 == 0:
        raise InputFileError(
            f"{HARMONIC}: order {order}: three phases in star cancel every third order; delete the entry"
        )
    if axis == "A":
        return harmonic.over(angle)
    quarter = pi / (2 * Integer(order))
    turned = angle - pi / 2
    return harmonic.over(turned + (quarter if order % 3 == 1 else -quarter))


def phase_currents(phases: int, i: Mapping[str, Expr]) -> dict[str, Expr]:
    """Return the currents of a star's three phases from those of its axes, A; empty for other motors."""
    if phases != STAR:
        return {}
    across = sqrt(3) / 2 * i["B"]
    return {"i_phase_a": i["A"], "i_phase_b": -i["A"] / 2 + across, "i_phase_c": -i["A"] / 2 - across}


def axes_of_two(first: Symbol, second: Symbol) -> dict[str, Expr]:
    """Return the axes of a star from the measured values of phases A and B, whose sum with C is zero."""
    return {"A": first, "B": (first + 2 * second) / sqrt(3)}
