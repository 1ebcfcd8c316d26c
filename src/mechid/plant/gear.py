"""Gear of any law, with kinematic errors, a stiffness that varies with the angle, and tooth meshes."""

from __future__ import annotations

from collections.abc import Sequence

from sympy import Expr, Float, Integer, Symbol, diff, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block, Extension, Rival, Series
from mechid.plant.drive_train import PER_STEP, alpha, alpha_gear, omega, omega_gear
from mechid.plant.gear_laws import LAWS, D, GearLaw, twist, twist_rate
from mechid.plant.gear_mesh import HUNTING, mesh_lines, meshes, ratio_agreements
from mechid.plant.harmonic import ListedHarmonic, coordinates_of

G, T_rg, T_applied = symbols("G T_rg T_applied")
ERROR, STIFFNESS = "gear.kinematic_error", "gear.stiffness_variation"
SMALLEST_ORDER = 1e-6
"""Smallest order of a kinematic error or a stiffness variation, periods per turn of the input."""
ERROR_ORDERS = (1, 2, 4)
"""Harmonics of the kinematic error, per turn of the input, that are tried if the file lacks them."""
RARER_ERROR_ORDERS = (3, 5, 6, 7, 8)
"""Harmonics that are tested against a finished fit in addition."""
OZGUVEN = "Ozguven, Houser, J. Sound Vib. 121 (1988) 383-411: varying mesh stiffness"
TUTTLE = "Tuttle, Seering, IEEE Trans. Robotics and Automation 12 (1996) 368-374"


def gear(
    law: str = "linear", error_orders: Sequence[int | None] = (), *, stiffness_variations: int = 0, mesh_count: int = 0
) -> Block:
    """Gear between rotor and output.

    The linear gear without kinematic error is the paper's, equations (7) and (9) of [Kornienko2013]_,
    T_rg = K_s/G^2 (alpha - G alpha_g) + D/G^2 (omega - G omega_g), T_applied = G T_rg; K_s in N m/rad and D in
    N m s/rad at the output, T_rg in N m at the rotor. The ratio may be negative. In general

        twist = alpha/G + e(alpha) - alpha_g,   T_applied = law(twist, twist'),   T_rg = (1/G + e'(alpha)) T_applied

    with the kinematic error e(alpha) = sum E_k sin(k alpha + phi_k) at the output, k per turn of the input, after
    Tuttle and Seering (1996); T_rg follows from T_applied by virtual work. `unwound_angle` gives the start of a record.

    A stiffness that varies, v(alpha) = sum V_k sin(k alpha + phi_k) over the mean, stores (1 + v) W(twist) with the
    energy W of the law. The torques are its derivatives with respect to both angles, so that no energy is made:

        T_applied = law(twist, twist') + v W',   T_rg = (1/G + e'(alpha)) T_applied + v'(alpha) W

    Parameters
    ----------
    law : str
        One of `LAWS`.
    error_orders : sequence of int or None
        Harmonics k of the kinematic error; None: k is a value of the kernel and need not be a whole number.
    stiffness_variations : int
        Number of harmonics of the stiffness, whose orders are values of the kernel.
    mesh_count : int
        Number of tooth meshes whose numbers of teeth are stated (`gear_mesh`); the equations do not need them.
    """
    chosen, ratio = LAWS[law](), _ratio()
    errors: list[ListedHarmonic] = []
    variations = [_variation(index) for index in range(stiffness_variations)]
    if law == "linear" and not error_orders and not variations:
        K_s = Symbol("K_s")
        # At the rotor, as in the paper: a single term instead of the twist and its rate.
        torque = K_s / G**2 * (alpha - G * alpha_gear) + D / G**2 * (omega - G * omega_gear)
        terms, out = {T_rg: torque}, G * T_rg
    else:
        errors = [_error(index, order) for index, order in enumerate(error_orders)]
        terms, out = _general_terms(chosen, errors, variations), T_applied
    listed = (*errors, *variations)
    return Block(
        name="gear",
        table="gear",
        declarations=(
            ratio,
            *chosen.declarations,
            *(d for one in listed for d in one.declarations),
            *(d for one in meshes(mesh_count) for d in one.declarations),
        ),
        coordinates=coordinates_of(listed),
        polar=tuple(one.polar for one in listed),
        inputs=(alpha, omega, alpha_gear, omega_gear),
        terms=terms,
        outputs={"T_rg": T_rg, "T_applied": out},
        switch=chosen.switch,
        extensions=(*_error_extensions(error_orders), *_mesh_extensions(mesh_count)),
        named_orders=mesh_lines(mesh_count),
        agreements=ratio_agreements(mesh_count),
        series=(Series(per_step=PER_STEP, entry=_error_extension),),
        rivals=_rivals() if law == "linear" else (),
        reference=chosen.reference,
    )


def _general_terms(
    law: GearLaw, errors: Sequence[ListedHarmonic], variations: Sequence[ListedHarmonic]
) -> dict[Symbol, Expr]:
    """Return the terms of any law with kinematic errors and variations of its stiffness."""
    lever, variation = symbols("lever v_s")
    slope: Expr = 1 / G + sum((diff(e.over(alpha), alpha) for e in errors), Integer(0))
    # Without errors the lever is the constant 1/G and needs no term.
    used = lever if errors else slope
    torque, reaction = law.torque, used * T_applied
    terms: dict[Symbol, Expr] = {lever: slope} if errors else {}
    if variations:
        varied = sum((v.over(alpha) for v in variations), Integer(0))
        terms[variation] = varied
        torque = torque + variation * diff(law.energy, twist)
        reaction = reaction + diff(varied, alpha) * law.energy
    return terms | {
        twist: _rigid_output_angle(alpha, errors) - alpha_gear,
        twist_rate: used * omega - omega_gear,
        T_applied: torque,
        T_rg: reaction,
    }


def _mesh_extensions(count: int) -> tuple[Extension, ...]:
    """Return the kinematic errors and the variations of the stiffness that the tooth meshes may have."""
    errors = tuple(
        Extension(
            name=f"{ERROR}:{line.name}",
            words=f"kinematic error of the gear: {line.words}, {{order:.6g}} per turn of its input",
            table=ERROR,
            structure={"order": line.cycles},
            widths={"amplitude": Float(1e-4)},
            values=line.values,
            # Two teeth meet so rarely that few records hold a period.
            grown=not line.name.endswith(HUNTING),
        )
        for line in mesh_lines(count)
    )
    variations = tuple(
        Extension(
            name=f"{STIFFNESS}:{line.name}",
            words=f"stiffness of the gear varies with the {line.words}, {{order:.6g}} per turn of its input",
            table=STIFFNESS,
            structure={"order": line.cycles},
            widths={"amplitude": Float(0.1)},
            values=line.values,
            grown=False,
        )
        for line in mesh_lines(count, teeth_only=True)
    )
    return (*errors, *variations)


def _error_extensions(orders: Sequence[int | None]) -> tuple[Extension, ...]:
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


def unwound_angle(start: Expr, error_orders: Sequence[int | None] = ()) -> Expr:
    """Return the output angle, rad, at which the twist is zero for an input angle `start`, rad.

    A gear at rest without load is not wound up by its own error: alpha_g = alpha/G + e(alpha).
    """
    return _rigid_output_angle(start, [_error(index, order) for index, order in enumerate(error_orders)])


def _rigid_output_angle(turned: Expr, errors: Sequence[ListedHarmonic]) -> Expr:
    """Return the output angle, rad, of a rigid gear with the given input angle."""
    return turned / G + sum((e.over(turned) for e in errors), Integer(0))


def _variation(index: int) -> ListedHarmonic:
    """Return one harmonic of the stiffness, over the input's angle."""
    return ListedHarmonic(
        table=STIFFNESS,
        index=index,
        order=None,
        least=SMALLEST_ORDER,
        letters=("n_v", "V_", "phi_v", "v_c", "v_s"),
        unit="1",
        most=1.0,
        source=OZGUVEN,
        meanings=(
            "periods of the stiffness per input turn",
            "amplitude of the variation of the stiffness over its mean",
            "phase of the variation of the stiffness",
        ),
    )


def _error(index: int, order: int | None) -> ListedHarmonic:
    """Return one harmonic of the kinematic error, over the input's angle."""
    return ListedHarmonic(
        table=ERROR,
        index=index,
        order=order,
        least=SMALLEST_ORDER,
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
