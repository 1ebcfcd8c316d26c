"""Assemblies of the library: the blocks of each, and the quantities that it can measure."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace

from sympy import Expr, Integer

from mechid.errors import InputFileError
from mechid.parameter import Declaration, Role
from mechid.plant import cable, dc_motor, friction, test_stand, unbalance
from mechid.plant.block import Block
from mechid.plant.drive import CURRENTS, VOLTAGES, measured_drive
from mechid.plant.drive_train import COMMANDED, INERTIA, rotor
from mechid.plant.friction import OUTPUT, ROTOR, Site
from mechid.plant.friction_position import vary_with_angle
from mechid.plant.gear import ERROR, STIFFNESS, gear, unwound_angle
from mechid.plant.gear_laws import LAWS as GEAR_LAWS
from mechid.plant.gear_mesh import TABLE as MESHES
from mechid.plant.housing import FORMS, SECOND, housing, rigid_housing
from mechid.plant.layout import STEPPER_GEAR_MASS, Base, Layout, Parts
from mechid.plant.load import load
from mechid.plant.motor import stepper_parts
from mechid.plant.moving_base import Bodies, base_on_modes, driven_base
from mechid.plant.phases import scales_of
from mechid.plant.ports import Port
from mechid.plant.start import ANGLE

MOTOR_QUANTITIES = {"rotor_angle": "rotor.alpha", "rotor_rate": "rotor.omega"}
BASE_TORQUE, LINE_TORQUE = "transducer.T_base", "torque_below_cut_off"
LINE_ORDER = 8
"""Order of the filter in front of the sampling of torque lines: the steepest available."""
OUTPUT_QUANTITIES = {"output_angle": "load.alpha_gear", "output_rate": "load.omega_gear"}


def exported_quantities(offered: Iterable[str]) -> list[str]:
    """Return the quantities that an export outputs: phase voltages are its inputs, and lines belong to the budget."""
    return [q for q in offered if q != LINE_TORQUE and not q.startswith("voltage_phase")]


def _geared_stepper(layout: Layout) -> Parts:
    """Return the paper's mechanism: stepper, rotor, gear, load, housing, test stand."""
    drive = layout.law("stepper", (*VOLTAGES, *CURRENTS), "drive")
    motor, driven, currents = stepper_parts(layout, drive)
    stand, wiring, torques = _stand(layout)
    blocks = [
        *motor,
        rotor(turns=layout.turns),
        *_friction(layout, _site(layout, drive), geared=True),
        _gear(layout),
        *_load_blocks(layout),
        *_base(layout, {"rotor": "free", "load": "free_out" if OUTPUT.table in layout.tables else ""}),
        *stand,
    ]
    return blocks, {**driven, **wiring}, {**torques, **MOTOR_QUANTITIES, **OUTPUT_QUANTITIES, **currents}


def _ungeared_stepper(layout: Layout) -> Parts:
    """Return a stepper, by default on a current drive, with its load on its own shaft."""
    drive = layout.law("stepper", (*CURRENTS, *VOLTAGES), "drive")
    motor, driven, currents = stepper_parts(layout, drive)
    stand, wiring, torques = _stand(layout, loaded=False)
    blocks = [
        *motor,
        rotor(
            geared=False,
            # Without a gear the rotor is the output: its inertia is that of the load.
            inertia=replace(INERTIA, role=Role.LOAD_INERTIA),
            turns=layout.turns,
            pushed=Port.OUTPUT in layout.ports,
        ),
        *_friction(layout, _site(layout, drive)),
        *_base(layout, {"rotor": "free"}),
        *stand,
    ]
    return blocks, {**driven, **wiring}, {**torques, **MOTOR_QUANTITIES, **currents}


def _two_mass(layout: Layout) -> Parts:
    """Return two masses and a gear, with a measured torque at the first mass."""
    site = replace(ROTOR, holding=None, damping=None)
    inertia = Declaration(
        "motor.inertia", "J_rot", "kg m2", "inertia of the motor's side", lower=0.0, source="the drive"
    )
    stand, wiring, torques = _stand(layout)
    blocks = [
        measured_drive((("torque", "T_mot"),), "drive", _offset("N m")),
        rotor(start=Integer(0), inertia=inertia),
        *_friction(layout, site, geared=True),
        _gear(layout),
        *_load_blocks(layout, Integer(0)),
        *stand,
    ]
    return blocks, wiring, {**MOTOR_QUANTITIES, **OUTPUT_QUANTITIES, **torques}


def _brushed_dc(layout: Layout) -> Parts:
    """Return a brushed DC motor with measured voltage and the load on its shaft, optionally held by a spring."""
    site = replace(ROTOR, holding=None, damping=dc_motor.DAMPING)
    sprung = dc_motor.SPRING in layout.tables
    stand, wiring, torques = _stand(layout, loaded=False)
    blocks = [
        measured_drive((("voltage", "u_mot"),), "drive", _offset("V")),
        dc_motor.dc_winding(),
        rotor(geared=sprung, start=Integer(0), inertia=dc_motor.INERTIA),
        *([dc_motor.shaft_spring()] if sprung else []),
        *_friction(layout, site),
        *stand,
    ]
    wiring |= {"rotor.T_rg": "spring.T_spring"} if sprung else {}
    return blocks, wiring, {**MOTOR_QUANTITIES, "current": "winding.i", **torques}


def _direct(quantity: str) -> Callable[[Layout], Parts]:
    """Return a mass on friction with a measured torque, or a measured force: a rotating or a sliding axis."""
    turning = quantity == "torque"
    unit, rate = ("N m", "rad/s") if turning else ("N", "m/s")
    inertia = Declaration(
        key="load.inertia" if turning else "load.mass",
        symbol="J_rot" if turning else "M",
        unit="kg m2" if turning else "kg",
        meaning="moving inertia" if turning else "moving mass",
        lower=0.0,
        source="the drive",
    )
    start_rate = Declaration(
        "load.start_rate", "omega_start", rate, "speed at the start of the records", default=0.0, source="the records"
    )
    unbalance = Declaration(
        key="load.unbalance",
        symbol="W_u",
        unit="N m",
        meaning="mass times gravity times the distance of the centre of mass from the axis; it hangs at angle 0",
        default=0.0,
        source="a pendulum's equation",
    )
    names = ("output_angle", "output_rate") if turning else ("position", "velocity")

    def parts(layout: Layout) -> Parts:
        site = replace(
            ROTOR, torque=unit, viscous=f"{unit} s/{rate.split('/')[0]}", rate=rate, holding=None, damping=None
        )
        blocks = [
            measured_drive(((quantity, "T_mot"),), "drive", _offset(unit)),
            rotor(
                geared=False,
                start=Integer(0),
                inertia=inertia,
                start_rate=start_rate,
                unbalance=unbalance if turning else None,
            ),
            *_friction(layout, site),
        ]
        return blocks, {}, dict(zip(names, ("rotor.alpha", "rotor.omega"), strict=True))

    return parts


ASSEMBLIES: Mapping[str, Callable[[Layout], Parts]] = {
    STEPPER_GEAR_MASS: _geared_stepper,
    "current_driven_stepper": _ungeared_stepper,
    "direct_torque_drive": _direct("torque"),
    "direct_force_drive": _direct("force"),
    "two_mass_drive": _two_mass,
    "brushed_dc_drive": _brushed_dc,
}
"""Assemblies by their names in mechanism.toml; the first is the default."""


def _friction(layout: Layout, site: Site, *, geared: bool = False) -> tuple[Block, ...]:
    """Return the friction law with its variation over the angle."""
    laws = friction.LAWS if geared else friction.UNGEARED_LAWS
    return vary_with_angle(laws[layout.law("friction", tuple(laws))](site), site, layout, geared=geared)


def _gear(layout: Layout) -> Block:
    """Return the gear with the lists of its errors, variations and meshes."""
    return gear(
        layout.law("gear", tuple(GEAR_LAWS)),
        layout.orders.get(ERROR, ()),
        stiffness_variations=layout.count(STIFFNESS),
        mesh_count=layout.count(MESHES),
    )


def _site(layout: Layout, drive: str) -> Site:
    holding, damping = scales_of(drive, layout.phases)
    return replace(ROTOR, holding=holding, damping=damping)


def _load_blocks(layout: Layout, start: Expr = COMMANDED) -> list[Block]:
    """Return the load behind a rotor with a given start angle, and the blocks that act on it besides the gear."""
    rubbed, cabled, unbalanced = (name in layout.tables for name in (OUTPUT.table, cable.TABLE, unbalance.TABLE))
    _refuse_own_load(layout)
    # The load starts where the gear is not wound up, whatever its kinematic error is there.
    at = unwound_angle(start + ANGLE, layout.orders.get(ERROR, ()))
    body = load(
        modes=len(layout.orders.get("load.mode", ())),
        rubbed=rubbed,
        cabled=cabled,
        unbalanced=unbalanced,
        start=at,
        turns=layout.turns,
        pushed=Port.OUTPUT in layout.ports,
    )
    laws = cable.LAWS
    return [
        body,
        *([friction.dry_output(OUTPUT)] if rubbed else []),
        *([laws[layout.law(cable.TABLE, tuple(laws))]()] if cabled else []),
        *([unbalance.unbalance()] if unbalanced else []),
    ]


def _refuse_own_load(layout: Layout) -> None:
    """Refuse tables that act on the library's load together with a load of the user's own."""
    beside = sorted({cable.TABLE, unbalance.TABLE} & layout.tables)
    if beside and "load" in layout.own:
        raise InputFileError(
            f"{beside[0]}: stands beside a load of your own, which does not know of it; write its torque into your "
            "block, or take the library's load"
        )


def _base(layout: Layout, bodies: Bodies) -> list[Block]:
    """Return the base, if it moves."""
    if layout.flying is None or layout.flying.base is Base.HELD:
        return []
    return [driven_base(bodies) if layout.flying.base is Base.DRIVEN else base_on_modes(layout.flying.modes, bodies)]


def _stand(layout: Layout, *, loaded: bool = True) -> tuple[list[Block], dict[str, str], dict[str, str]]:
    """Return housing, transducer and the stages behind it, their wiring, and the outputs of the torques.

    In flight there is none of these; the torque is that on the base. A second output is that torque below a cut-off,
    whose lines can be read without aliases; so too for a mechanism in flight configuration that keeps its stand.
    """
    blocks, wiring, last = _measuring_chain(layout, loaded=loaded)
    if layout.flying is None:
        return blocks, wiring, {"torque": last}
    below = f"{test_stand.LINE_FILTER}.T"
    return (
        [*blocks, test_stand.line_filter(LINE_ORDER)],
        {**wiring, below: last},
        {"torque": last, LINE_TORQUE: below},
    )


def _measuring_chain(layout: Layout, *, loaded: bool) -> tuple[list[Block], dict[str, str], str]:
    """Return the stages between mechanism and recorder, their wiring, and the output of the torque."""
    form = layout.law("housing", FORMS, "form") if "housing" in layout.tables else None
    second = _second_mode(layout)
    blocks = [housing(form, second=second) if form else rigid_housing(), test_stand.base_torque(loaded=loaded)]
    wiring, last = {}, BASE_TORQUE
    stages: list[Block] = []
    if "transducer" in layout.tables:
        stages.append(test_stand.TRANSDUCERS[layout.law("transducer", tuple(test_stand.TRANSDUCERS))]())
    if "charge_amplifier" in layout.tables:
        stages.append(test_stand.charge_amplifier())
    if "anti_alias" in layout.tables:
        (order,) = layout.whole_orders("anti_alias")
        stages.append(test_stand.anti_alias(order))
    # Each stage reads the one before it, in the order of the signal path.
    for stage in stages:
        wiring[f"{stage.name}.T"] = last
        last = f"{stage.name}.T"
    return [*blocks, *stages], wiring, last


def _second_mode(layout: Layout) -> bool:
    """Return whether the housing has a second mode; refuse one on a housing of the user's own."""
    there = SECOND.table in layout.tables
    if there and "housing" in layout.own:
        raise InputFileError(
            f"{SECOND.table}: stands beside a housing of your own, which does not know of it; write "
            "both modes into your block, or take the library's housing"
        )
    return there


def _offset(unit: str) -> Declaration:
    return Declaration(
        key="offset",
        symbol="T_0",
        unit=unit,
        meaning="constant part of the drive that is not in its channel",
        default=0.0,
        source="the test stand",
    )
