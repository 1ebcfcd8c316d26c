"""Stepper motor (E2P): windings, detent torque, and their sum."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from sympy import Expr, Float, Integer, Symbol, pi, sin, symbols
from sympy.parsing.sympy_parser import parse_expr

from mechid.parameter import Declaration, Role
from mechid.plant import current_limit, detent, detent_hysteresis, magnet, saliency, supply
from mechid.plant.block import Block, Extension
from mechid.plant.harmonic import ListedHarmonic, coordinates_of
from mechid.plant.phases import HARMONIC, STAR, harmonic_of_axis, phase_currents, torque_share
from mechid.plant.saliency import Inductance
from mechid.plant.start import start as own_start

p, R, L, k_m, k_v, shift_B = symbols("p R L k_m k_v shift_B")
alpha, omega = symbols("alpha omega")
HUGHES = "Hughes, Drury, Electric Motors and Drives"
PHASES = {"A": 1, "B": -1}
"""Phases, and the sign with which an imbalance enters each."""
ANGLES = {"A": p / 2 * alpha, "B": p / 2 * alpha + shift_B}
"""Electrical angle of each phase."""
AXES = {"A": p / 2 * alpha, "B": p / 2 * alpha + pi / 2}
"""Electrical angle of each axis of three phases in star."""
HARMONIC_ORDERS: Mapping[int, str] = {3: "3rd", 5: "5th", 7: "7th", 9: "9th", 2: "2nd", 4: "4th"}
"""Harmonics of the torque constant that are tried; even ones arise from rotor halves that differ."""
USUAL_HARMONICS = (3, 5)
"""Harmonics that growth frees first."""


def windings(
    *,
    harmonics: Sequence[int] = (),
    apart: bool = False,
    salient: bool = False,
    sagging: bool = False,
    commanded: bool = True,
    phases: int = 2,
) -> Block:
    """Two windings: L di/dt = u - R i - k_v omega sin(p/2 alpha + shift), T = k_m i sin(p/2 alpha + shift).

    Equations (1) to (3) of [Kornienko2013]_; i in A, u in V, alpha in rad, omega in rad/s, T in N m.
    Phase A has no shift, phase B `phase_shift_deg` (90 deg by default).

    Parameters
    ----------
    harmonics : sequence of int
        Orders h of the torque constant's harmonics per electrical period: sin(x) becomes
        sin(x) + sum c_h sin(h x + phi_h), in the torque and in the back-EMF alike.
    apart : bool
        Whether the phases differ: R, L and k_m are (1 + r) times the file's in phase A and (1 - r) times in
        phase B, and each phase has a voltage offset.
    salient : bool
        Whether the inductance varies with the angle (`saliency`).
    sagging : bool
        Whether the source behind the drive has a resistance (`supply`).
    commanded : bool
        Whether the voltages come from a command, not from a measurement.
    phases : {2, 3, 4}
        Number of phases. Three in star are represented by two axes (`phases`), to which currents and voltages belong
        then; of four, one of the two on a pole conducts at a time, with the sign of its half of the winding.
    """
    angles = AXES if phases == STAR else ANGLES
    i = {x: Symbol(f"i_{x}") for x in PHASES}
    u = {x: Symbol(f"u_{x}_in") for x in PHASES}
    extra, shape, share = _harmonics(harmonics), _shapes(harmonics, phases), _shares(apart)
    coil = {x: Inductance.over(angles[x], L * share["L"][x], salient=salient) for x in PHASES}
    offset = {x: Symbol(f"u_0{x}") if apart else Integer(0) for x in PHASES}
    fed = {x: u[x] - supply.SAG * supply.DUTIES[x] if sagging else u[x] for x in PHASES}
    emf = {x: omega * (k_v * share["k"][x] * shape[x] + coil[x].slope * i[x]) for x in PHASES}
    rates = {i[x]: (fed[x] + offset[x] - R * share["R"][x] * i[x] - emf[x]) / coil[x].value for x in PHASES}
    resistances = {x: R * share["R"][x] for x in PHASES}
    # A record begins after the coils' currents have settled at the first voltages, at rest without back-EMF.
    settled = {x: (u[x] + offset[x]) / resistances[x] for x in PHASES}
    if sagging:
        settled = supply.settled_currents(settled, resistances, torque_share(phases))
    unequal = _imbalance(("resistance", "r_R"), ("inductance", "r_L"), unit="V") if apart else ()
    own = {x: Symbol(f"i_{x}_start") for x in PHASES}
    return Block(
        name="windings",
        table="stepper",
        declarations=(
            *_electrical(phases),
            *([supply.RESISTANCE] if sagging else []),
            *unequal,
            *([saliency.SHARE] if salient else []),
            *(d for h in extra for d in h.declarations),
        ),
        coordinates={**_shift(phases), **coordinates_of(extra)},
        polar=tuple(h.polar for h in extra),
        inputs=(*u.values(), *(supply.DUTIES.values() if sagging else ()), alpha, omega),
        terms={supply.SAG: supply.sag(i, torque_share(phases))} if sagging else {},
        rates=rates,
        initial={i[x]: settled[x] + own[x] for x in PHASES},
        starts=tuple(
            own_start(
                f"current_{x.lower()}",
                own[x],
                "A",
                f"current of phase {x} at the start, off where it settles",
                "T_hold/k_m",
            )
            for x in PHASES
        ),
        outputs={
            "T_coils": torque_share(phases) * _torque(i, shape, share) + sum(coil[x].torque(i[x]) for x in PHASES),
            "i_A": i["A"],
            "i_B": i["B"],
            **phase_currents(phases, i),
        },
        extensions=(
            *_harmonic_extensions(harmonics, phases),
            *(() if apart or phases == STAR else _apart_extensions("voltage")),
            *(() if salient or phases == STAR else [saliency.EXTENSION]),
            *([supply.EXTENSION] if commanded and not sagging else []),
        ),
    )


def current_fed(
    *,
    harmonics: Sequence[int] = (),
    apart: bool = False,
    limited: bool = False,
    commanded: bool = True,
    phases: int = 2,
) -> Block:
    """Two windings on a current drive: T = k_m i sin(p/2 alpha + shift), at any voltage.

    Equation (3) of [Kornienko2013]_; parameters as those of `windings`, offsets in A. If the drive is `limited`,
    its loops (`current_limit`) take the back-EMF from here.
    """
    i = {x: Symbol(f"i_{x}_in") for x in PHASES}
    extra, shape, share = _harmonics(harmonics), _shapes(harmonics, phases), _shares(apart)
    offset = {x: Symbol(f"i_0{x}") if apart else Integer(0) for x in PHASES}
    carried = {x: i[x] + offset[x] for x in PHASES}
    emf = {f"emf_{x}": k_v * share["k"][x] * omega * shape[x] for x in PHASES}
    return Block(
        name="windings",
        table="stepper",
        declarations=(
            _POLES,
            # Torque is k_m times the current here: of a larger current a smaller constant gives the same torque.
            replace(_TORQUE_CONSTANT, supply_power=-1),
            *_shift_declarations(phases),
            *(_imbalance(unit="A") if apart else ()),
            *(d for h in extra for d in h.declarations),
        ),
        coordinates={**_shift(phases), **coordinates_of(extra)},
        polar=tuple(h.polar for h in extra),
        inputs=(*i.values(), alpha, *([omega] if limited else [])),
        outputs={
            "T_coils": torque_share(phases) * _torque(carried, shape, share),
            **(emf if limited else {}),
            **phase_currents(phases, i),
        },
        extensions=(
            *_harmonic_extensions(harmonics, phases),
            *(() if apart or phases == STAR else _apart_extensions("current")),
        ),
        rivals=(current_limit.RIVAL,) if commanded and not limited and phases != STAR else (),
    )


def _torque(i: dict[str, Expr], shape: dict[str, Expr], share: dict[str, dict[str, Expr]]) -> Expr:
    return sum((k_m * share["k"][x] * i[x] * shape[x] for x in PHASES), Integer(0))


def _shapes(harmonics: Sequence[int], phases: int) -> dict[str, Expr]:
    """Return each phase's torque coupling over the angle: a sine and its harmonics."""
    extra, angles = _harmonics(harmonics), AXES if phases == STAR else ANGLES
    return {x: sum((harmonic_of_axis(h, x, angle, phases) for h in extra), sin(angle)) for x, angle in angles.items()}


def _shares(apart: bool) -> dict[str, dict[str, Expr]]:
    """Return each phase's R, L and k_m relative to those of the file."""
    own = {name: Symbol(f"r_{name}") if apart else Integer(0) for name in ("R", "L", "k")}
    return {name: {x: 1 + sign * r for x, sign in PHASES.items()} for name, r in own.items()}


_POLES = Declaration("poles", "p", "1", "number of poles", lower=2.0, structural=True, even=True)
_TORQUE_CONSTANT = Declaration("torque_constant", "k_m", "N m/A", "torque constant", lower=0.0, supply_power=1)
_PHASE_SHIFT = Declaration(
    key="phase_shift_deg",
    symbol="phi_shift",
    unit="deg",
    meaning="electrical angle from phase A to phase B",
    default=90.0,
    lower=-360.0,
    upper=360.0,
)


def _shift(phases: int) -> dict[Symbol, Expr]:
    """Return the coordinate of phase B's angle; the axes of a star are at right angles."""
    return {} if phases == STAR else {shift_B: Symbol("phi_shift") * pi / 180}


def _shift_declarations(phases: int) -> tuple[Declaration, ...]:
    return () if phases == STAR else (_PHASE_SHIFT,)


def _electrical(phases: int) -> tuple[Declaration, ...]:
    return (
        _POLES,
        Declaration(
            key="coil_resistance",
            symbol="R",
            unit="ohm",
            meaning="coil resistance",
            lower=0.0,
            spread=1.25,
            supply_power=2,
            role=Role.WINDING_RESISTANCE,
        ),
        Declaration("coil_inductance", "L", "H", "coil inductance", lower=0.0, supply_power=2),
        _TORQUE_CONSTANT,
        Declaration("back_emf_constant", "k_v", "V s/rad", "back-EMF constant", lower=0.0, tied_to="torque_constant"),
        *_shift_declarations(phases),
    )


def _imbalance(*more: tuple[str, str], unit: str) -> tuple[Declaration, ...]:
    """Half the difference of phase A and phase B over their mean, and the phases' offsets."""
    named = (*more, ("torque_constant", "r_k"))
    halves = tuple(
        Declaration(
            key=f"stepper.imbalance.{key}",
            symbol=symbol,
            unit="1",
            meaning=f"half the difference of {key.replace('_', ' ')}, A less B, over the mean",
            lower=-0.9,
            upper=0.9,
            default=0.0,
            source=HUGHES,
        )
        for key, symbol in named
    )
    quantity = "voltage" if unit == "V" else "current"
    offsets = tuple(
        Declaration(
            key=f"stepper.imbalance.offset_{x.lower()}",
            symbol=f"{'u' if unit == 'V' else 'i'}_0{x}",
            unit=unit,
            meaning=f"{quantity} offset of phase {x}",
            default=0.0,
            source=HUGHES,
        )
        for x in PHASES
    )
    return (*halves, *offsets)


def _harmonic_extensions(harmonics: Sequence[int], phases: int) -> tuple[Extension, ...]:
    """Return the harmonics of the torque constant that may be added, of 3 %; in star every third cancels."""
    return tuple(
        Extension(
            name=f"{HARMONIC}:{order}",
            words=f"{ordinal} harmonic of the torque constant",
            table=HARMONIC,
            order=order,
            structure={"order": Integer(order)},
            widths={"amplitude": Float(0.03)},
            rarer=order not in USUAL_HARMONICS,
        )
        for order, ordinal in HARMONIC_ORDERS.items()
        if order not in harmonics and not (phases == STAR and order % 3 == 0)
    )


def _apart_extensions(driven: str) -> tuple[Extension, ...]:
    """Return a difference of the phases of 3 %, and offsets of 2 % of the supply, for a voltage or a current drive."""
    table = "stepper.imbalance"
    halves, words, driven_by = {
        "voltage": (("resistance", "inductance", "torque_constant"), "torque constant, resistance or inductance", "U"),
        "current": (("torque_constant",), "torque constant", "I_peak"),
    }[driven]
    return (
        Extension(
            name=table,
            words=f"the two phases differ in {words}",
            table=table,
            widths=dict.fromkeys(halves, Float(0.03)),
        ),
        Extension(
            name="stepper.phase_offset",
            words=f"a constant {driven} is added in each phase",
            table=table,
            widths={f"offset_{x.lower()}": Float(0.02) * Symbol(driven_by) for x in PHASES},
        ),
    )


def _harmonics(orders: Sequence[int]) -> tuple[ListedHarmonic, ...]:
    """Return the harmonics of the torque constant, over each phase's electrical angle."""
    return tuple(
        ListedHarmonic(
            table=HARMONIC,
            index=index,
            order=order,
            letters=("h_", "C_h", "phi_h", "c_h", "s_h"),
            unit="1",
            source=HUGHES,
            least=2.0,
            turns=p / 2,
            of_phase=True,
            meanings=(
                "periods of the torque constant's harmonic per electrical period",
                "amplitude of the harmonic over the torque constant",
                "phase of the harmonic",
            ),
        )
        for index, order in enumerate(orders)
    )


HOLDING = "holding torque"


def motor_torque(
    orders: Sequence[int | None], holding: str | None = None, *, lagging: bool = False, warm: bool = False
) -> Block:
    """T_mot = T_A + T_B - T_D, equation (5) of [Kornienko2013]_, T_D with its hysteresis and over temperature; N m.

    Parameters
    ----------
    orders : sequence of int or None
        Periods per electrical period of the detents, None where not an integer.
    holding : str or None
        Torque of one phase at rest in the file's symbols, if known.
    lagging, warm : bool
        Whether the detent torque has hysteresis, and whether it changes with the motor's temperature.
    """
    T_coils, T_mot = symbols("T_coils T_mot")
    T_D = (*symbols(f"T_D1:{len(orders) + 1}"), *((detent_hysteresis.T_hys,) if lagging else ()))
    scale = parse_expr(holding) if holding else None
    return Block(
        name="motor",
        table="stepper",
        inputs=(T_coils, *T_D, *((magnet.factor,) if warm else ())),
        terms={T_mot: T_coils - (magnet.factor if warm else 1) * sum(T_D)},
        outputs={"T_mot": T_mot},
        scales={} if scale is None else {HOLDING: scale},
        extensions=() if scale is None else detent.extensions(orders, scale),
        series=() if scale is None else (detent.series(scale),),
        rivals=() if scale is None or lagging else (detent_hysteresis.rival(scale),),
    )
