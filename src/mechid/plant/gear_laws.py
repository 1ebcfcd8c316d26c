"""Gear laws: linear, piecewise linear as in harmonic-drive catalogues, or with backlash."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from sympy import Expr, Symbol, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Guard, Switch

D, twist, twist_rate = symbols("D twist twist_rate")
HARMONIC = "Harmonic Drive SE, Engineering Data: torsional stiffness K1, K2, K3 at T1, T2"
NORDIN = "Nordin, Gutman, Automatica 38 (2002) 1633-1649"


@dataclass(frozen=True, kw_only=True)
class GearLaw:
    """Torque at the output, N m, as a function of `twist` (rad) and `twist_rate` (rad/s) at the output.

    `energy` is that of the wound-up gear, J; its derivative with respect to the twist is the torque without damping.
    """

    torque: Expr
    energy: Expr
    declarations: tuple[Declaration, ...]
    switch: Switch | None = None
    reference: str = "Kornienko2013"


def linear() -> GearLaw:
    """K_s twist + D twist'."""
    K_s = Symbol("K_s")
    return GearLaw(
        torque=K_s * twist + D * twist_rate, energy=K_s * twist**2 / 2, declarations=(_stiffness(), _damping())
    )


def piecewise_linear() -> GearLaw:
    """Torque over twist of slope K1 up to torque T1, K2 up to T2, K3 above, plus D twist'.

    With delta_1 = T1/K1 and delta_2 = delta_1 + (T2 - T1)/K2. Five modes; `mid` and `high` are 1 where the second
    and third slope apply, `side` is the sign of the twist.
    """
    K_1, K_2, K_3, T_1, T_2, mid, high, side = symbols("K_s1 K_s2 K_s3 T_s1 T_s2 mid high side_gear")
    bend_1 = T_1 / K_1
    bend_2 = bend_1 + (T_2 - T_1) / K_2
    torque = K_1 * twist + mid * (K_2 - K_1) * (twist - side * bend_1) + high * (K_3 - K_2) * (twist - side * bend_2)
    energy = (
        K_1 * twist**2
        + mid * (K_2 - K_1) * (twist - side * bend_1) ** 2
        + high * (K_3 - K_2) * (twist - side * bend_2) ** 2
    ) / 2
    modes: dict[str, Mapping[Symbol, float]] = {"low": {mid: 0.0, high: 0.0, side: 0.0}}
    guards: dict[str, tuple[Guard, ...]] = {
        "low": (Guard(margin=bend_1 - twist, target="mid_up"), Guard(margin=bend_1 + twist, target="mid_down"))
    }
    for name, sign in (("up", 1), ("down", -1)):
        modes[f"mid_{name}"] = {mid: 1.0, high: 0.0, side: float(sign)}
        modes[f"high_{name}"] = {mid: 1.0, high: 1.0, side: float(sign)}
        guards[f"mid_{name}"] = (
            Guard(margin=sign * twist - bend_1, target="low"),
            Guard(margin=bend_2 - sign * twist, target=f"high_{name}"),
        )
        guards[f"high_{name}"] = (Guard(margin=sign * twist - bend_2, target=f"mid_{name}"),)
    entry = tuple(
        (sign * twist - bend, f"{zone}_{name}")
        # The outer zone first: beyond its bend the margin of the inner zone is positive too.
        for zone, bend in (("high", bend_2), ("mid", bend_1))
        for name, sign in (("up", 1), ("down", -1))
    )
    stiffnesses = tuple(
        Declaration(
            key=f"stiffness_{k}",
            symbol=f"K_s{k}",
            unit="N m/rad",
            meaning=f"gear stiffness at output, K{k} of the catalogue",
            lower=0.0,
            source=HARMONIC,
        )
        for k in (1, 2, 3)
    )
    torques = tuple(
        Declaration(
            key=f"torque_{k}",
            symbol=f"T_s{k}",
            unit="N m",
            meaning=f"output torque up to which K{k} holds",
            lower=0.0,
            source=HARMONIC,
            beyond="torque_1" if k == 2 else None,
        )
        for k in (1, 2)
    )
    return GearLaw(
        torque=torque + D * twist_rate,
        energy=energy,
        declarations=(*stiffnesses, *torques, _damping()),
        switch=Switch(
            name="gear",
            modes=modes,
            guards=guards,
            entry=entry,
            otherwise="low",
            ideal={mid: 0.0, high: 0.0, side: 0.0},
        ),
        reference=HARMONIC,
    )


def backlash() -> GearLaw:
    """K_s (twist - side b/2) + D twist' in contact, zero in the gap |twist| < b/2; Nordin and Gutman (2002).

    The damper acts in contact only: at a contact with nonzero speed the torque jumps by D twist'.
    """
    K_s, gap, contact, side = symbols("K_s b_gap contact side_gear")
    half = gap / 2
    switch = Switch(
        name="gear",
        modes={
            "gap": {contact: 0.0, side: 0.0},
            "up": {contact: 1.0, side: 1.0},
            "down": {contact: 1.0, side: -1.0},
        },
        guards={
            "gap": (Guard(margin=half - twist, target="up"), Guard(margin=half + twist, target="down")),
            "up": (Guard(margin=twist - half, target="gap"),),
            "down": (Guard(margin=-twist - half, target="gap"),),
        },
        entry=((twist - half, "up"), (-twist - half, "down")),
        otherwise="gap",
        # Without play the flanks are always in contact.
        ideal={contact: 1.0, side: 0.0},
    )
    play = Declaration(
        "backlash", gap.name, "rad", "free travel of the output from flank to flank", lower=0.0, source=NORDIN
    )
    return GearLaw(
        torque=contact * (K_s * (twist - side * half) + D * twist_rate),
        energy=contact * K_s * (twist - side * half) ** 2 / 2,
        declarations=(_stiffness(), _damping(), play),
        switch=switch,
        reference=NORDIN,
    )


def _stiffness() -> Declaration:
    return Declaration("stiffness", "K_s", "N m/rad", "gear stiffness at output", lower=0.0)


def _damping() -> Declaration:
    return Declaration("damping", "D", "N m s/rad", "gear damping at output", lower=0.0)


LAWS: Mapping[str, Callable[[], GearLaw]] = {
    "linear": linear,
    "piecewise_linear": piecewise_linear,
    "backlash": backlash,
}
"""Gear laws by their names in mechanism.toml; the first is the paper's."""
