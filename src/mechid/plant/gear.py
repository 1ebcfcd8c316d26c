"""Gears: linear, piecewise linear as in harmonic-drive catalogues, or with backlash; kinematic error is optional."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from sympy import Expr, Float, Integer, Symbol, diff, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block, Extension, Guard, Rival, Series, Switch
from mechid.plant.drive_train import PER_STEP, alpha, alpha_gear, omega, omega_gear
from mechid.plant.harmonic import ListedHarmonic, coordinates_of

G, D, T_rg, T_applied = symbols("G D T_rg T_applied")
twist, twist_rate = symbols("twist twist_rate")
HARMONIC = "Harmonic Drive SE, Engineering Data: torsional stiffness K1, K2, K3 at T1, T2"
NORDIN = "Nordin, Gutman, Automatica 38 (2002) 1633-1649"
ERROR = "gear.kinematic_error"
ERROR_ORDERS = (1, 2, 4)
"""Harmonics of the kinematic error, per turn of the input, that are tried if the file lacks them."""
RARER_ERROR_ORDERS = (3, 5, 6, 7, 8)
"""Harmonics that are tested against a finished fit in addition."""
TUTTLE = "Tuttle, Seering, IEEE Trans. Robotics and Automation 12 (1996) 368-374"


@dataclass(frozen=True, kw_only=True)
class GearLaw:
    """Torque at the output, N m, as a function of `twist` (rad) and `twist_rate` (rad/s) at the output."""

    torque: Expr
    declarations: tuple[Declaration, ...]
    switch: Switch | None = None
    reference: str = "Kornienko2013"


def gear(law: str = "linear", error_orders: Sequence[int] = ()) -> Block:
    """Gear between rotor and output.

    The linear gear without kinematic error is the paper's, equations (7) and (9) of [Kornienko2013]_,
    T_rg = K_s/G^2 (alpha - G alpha_g) + D/G^2 (omega - G omega_g), T_applied = G T_rg; K_s in N m/rad and D in
    N m s/rad at the output, T_rg in N m at the rotor. The ratio may be negative. In general

        twist = alpha/G + e(alpha) - alpha_g,   T_applied = law(twist, twist'),   T_rg = (1/G + e'(alpha)) T_applied

    with the kinematic error e(alpha) = sum E_k sin(k alpha + phi_k) at the output, k per turn of the input, after
    Tuttle and Seering (1996); T_rg follows from T_applied by virtual work. `unwound_angle` gives the start of a record.

    Parameters
    ----------
    law : str
        One of `LAWS`.
    error_orders : sequence of int
        Harmonics k of the kinematic error.
    """
    chosen, ratio = LAWS[law](), _ratio()
    if law == "linear" and not error_orders:
        K_s = Symbol("K_s")
        # At the rotor, as in the paper: a single term instead of the twist and its rate.
        torque = K_s / G**2 * (alpha - G * alpha_gear) + D / G**2 * (omega - G * omega_gear)
        terms, out = {T_rg: torque}, G * T_rg
        errors: list[ListedHarmonic] = []
    else:
        errors = [_error(index, order) for index, order in enumerate(error_orders)]
        lever = Symbol("lever")
        slope: Expr = 1 / G + sum((diff(e.over(alpha), alpha) for e in errors), Integer(0))
        terms = {lever: slope} if errors else {}
        # Without errors the lever is the constant 1/G and needs no term.
        used = lever if errors else slope
        terms |= {
            twist: _rigid_output_angle(alpha, errors) - alpha_gear,
            twist_rate: used * omega - omega_gear,
            T_applied: chosen.torque,
            T_rg: used * T_applied,
        }
        out = T_applied
    return Block(
        name="gear",
        table="gear",
        declarations=(ratio, *chosen.declarations, *(d for e in errors for d in e.declarations)),
        coordinates=coordinates_of(errors),
        polar=tuple(e.polar for e in errors),
        inputs=(alpha, omega, alpha_gear, omega_gear),
        terms=terms,
        outputs={"T_rg": T_rg, "T_applied": out},
        switch=chosen.switch,
        extensions=_error_extensions(error_orders),
        series=(Series(per_step=PER_STEP, entry=_error_extension),),
        rivals=_rivals() if law == "linear" else (),
        reference=chosen.reference,
    )


def _error_extensions(orders: Sequence[int]) -> tuple[Extension, ...]:
    """Return the harmonics of the kinematic error that may be added."""
    listed = (*ERROR_ORDERS, *RARER_ERROR_ORDERS)
    return tuple(_error_extension(order) for order in listed if order not in orders)


def _error_extension(order: int) -> Extension:
    """Return a harmonic of the kinematic error of 0.1 mrad, about 20 arc seconds."""
    return Extension(
        name=f"{ERROR}:{order}",
        words="kinematic error of the gear, {order:g} per turn of its input",
        table=ERROR,
        order=order,
        structure={"order": Integer(order)},
        widths={"amplitude": Float(1e-4)},
        grown=order in (*ERROR_ORDERS, *RARER_ERROR_ORDERS),
        rarer=order in RARER_ERROR_ORDERS,
    )


def _rivals() -> tuple[Rival, ...]:
    """Return the alternatives to a linear gear: three sizes of backlash, and load-dependent friction.

    A start from the smallest play finds small solutions that larger starts skip, since the play has no derivative at 0.
    """
    plays = tuple(
        Rival(
            name="gear.backlash",
            words="backlash of the gear",
            table="gear",
            law="backlash",
            free={"backlash": (play, play / 30, play * 30)},
            size="backlash",
            grown=grown,
        )
        for play, grown in ((Float(3e-7), False), (Float(5e-6), True), (Float(1.5e-4), True))
    )
    share = (Float(0.05), Float(1e-3), Float(1.0))
    return (
        *plays,
        Rival(
            name="friction.load_dependent",
            words="friction that grows with the torque in the gear",
            table="friction",
            law="load_dependent",
            free={"load_share": share},
            null="load_share",
            hides=True,
        ),
    )


def unwound_angle(start: Expr, error_orders: Sequence[int] = ()) -> Expr:
    """Return the output angle, rad, at which the twist is zero for an input angle `start`, rad.

    A gear at rest without load is not wound up by its own error: alpha_g = alpha/G + e(alpha).
    """
    return _rigid_output_angle(start, [_error(index, order) for index, order in enumerate(error_orders)])


def _rigid_output_angle(turned: Expr, errors: Sequence[ListedHarmonic]) -> Expr:
    """Return the output angle, rad, of a rigid gear with the given input angle."""
    return turned / G + sum((e.over(turned) for e in errors), Integer(0))


def linear() -> GearLaw:
    """K_s twist + D twist'."""
    return GearLaw(torque=Symbol("K_s") * twist + D * twist_rate, declarations=(_stiffness(), _damping()))


def piecewise_linear() -> GearLaw:
    """Torque over twist of slope K1 up to torque T1, K2 up to T2, K3 above, plus D twist'.

    With delta_1 = T1/K1 and delta_2 = delta_1 + (T2 - T1)/K2. Five modes; `mid` and `high` are 1 where the second
    and third slope apply, `side` is the sign of the twist.
    """
    K_1, K_2, K_3, T_1, T_2, mid, high, side = symbols("K_s1 K_s2 K_s3 T_s1 T_s2 mid high side_gear")
    bend_1 = T_1 / K_1
    bend_2 = bend_1 + (T_2 - T_1) / K_2
    torque = K_1 * twist + mid * (K_2 - K_1) * (twist - side * bend_1) + high * (K_3 - K_2) * (twist - side * bend_2)
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
        declarations=(_stiffness(), _damping(), play),
        switch=switch,
        reference=NORDIN,
    )


LAWS: Mapping[str, Callable[[], GearLaw]] = {
    "linear": linear,
    "piecewise_linear": piecewise_linear,
    "backlash": backlash,
}
"""Gear laws by their names in mechanism.toml; the first is the paper's."""


def _error(index: int, order: int) -> ListedHarmonic:
    """Return one harmonic of the kinematic error, over the input's angle."""
    return ListedHarmonic(
        table=ERROR,
        index=index,
        order=order,
        letters=("k_e", "E_", "phi_e", "e_c", "e_s"),
        unit="rad",
        source=TUTTLE,
        meanings=(
            "periods of the kinematic error per input turn",
            "amplitude of the kinematic error at the output",
            "phase of the kinematic error",
        ),
    )


def _ratio() -> Declaration:
    return Declaration("ratio", "G", "1", "transmission ratio", structural=True)


def _stiffness() -> Declaration:
    return Declaration("stiffness", "K_s", "N m/rad", "gear stiffness at output", lower=0.0)


def _damping() -> Declaration:
    return Declaration("damping", "D", "N m s/rad", "gear damping at output", lower=0.0)
