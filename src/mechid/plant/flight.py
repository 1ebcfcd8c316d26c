"""Flight configuration of a mechanism: its assembly without the test stand, its base held, driven or on modes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

from mechid.errors import InputFileError
from mechid.parameter import Parameter, Role, Status
from mechid.plant.assembly import plant_of
from mechid.plant.drive import COMMANDED, measured_quantities
from mechid.plant.layout import Base, Flying, Layout
from mechid.plant.mechanism import Mechanism
from mechid.plant.mechanisms import LINE_ORDER, LINE_TORQUE
from mechid.plant.plant import Plant
from mechid.plant.ports import Port
from mechid.plant.tables import TABLES, bench_reason, table_of
from mechid.plant.test_stand import LINE_FILTER

LOAD, MODE, DRIVE = "load", "load.mode", "drive"
CUT_OFF, ORDER = FILTER = (f"{LINE_FILTER}.frequency", f"{LINE_FILTER}.order")
"""Parameters of the filter in front of the sampling of torque lines."""
RECORD = "it belongs to one record"

ModeValues: TypeAlias = Sequence[tuple[float, float, float]]
"""Three values per mode: rad/s, damping, and effective inertia of a load, or shape at the interface of a base."""


def flight_layout(layout: Layout, load_modes: int | None = None, *, stand: bool = False) -> Layout:
    """Return the layout of a mechanism in flight, on a held base: that of the bench without the test stand.

    Parameters
    ----------
    layout : Layout
        Layout on the bench.
    load_modes : int or None
        Number of flexible modes of the load in flight; None keeps those of the bench.
    stand : bool
        Whether it keeps its test stand, except the measured channels that drove it.
    """
    # The drive goes even with the stand: in flight a command replaces the measured channels.
    flies = {name for name, table in TABLES.items() if name != DRIVE and (stand or not table.bench)}
    laws = {name: law for name, law in layout.laws.items() if name in flies}
    if "stepper" in laws:
        laws["stepper"] = COMMANDED.get(laws["stepper"], laws["stepper"])
    orders = {name: order for name, order in layout.orders.items() if name in flies}
    if load_modes is not None:
        orders = {**orders, MODE: (None,) * load_modes}
    return replace(
        layout,
        laws=laws,
        orders={name: order for name, order in orders.items() if order},
        tables=frozenset(layout.tables & flies),
        own={name: block for name, block in layout.own.items() if name in flies},
        flying=Flying(stand=stand and _has_stand(layout)),
    )


def _has_stand(layout: Layout) -> bool:
    """Return whether a layout has a table of the bench other than measured channels."""
    return any(TABLES[name].bench and name != DRIVE for name in layout.tables if name in TABLES)


def to_flight(
    mechanism: Mechanism,
    values: Mapping[str, float] | None = None,
    load_modes: ModeValues | None = None,
    *,
    stand: bool = False,
) -> Mechanism:
    """Return the flight configuration of a mechanism on the bench, on a held base.

    Parameters
    ----------
    mechanism : Mechanism
        As identified; its plant comes from a layout.
    values : mapping of dotted name to value
        Values that differ in flight, in the mechanism file's units. Tied parameters follow.
    load_modes : sequence of (rad/s, damping, kg m2) or None
        Flexible modes of the load in flight; None keeps those of the bench.
    stand : bool
        Whether it keeps its test stand, so that its torque is that measured by the transducer.

    Raises
    ------
    InputFileError
        It cannot fly, or a value is missing or invalid: one sentence with block and remedy.
    """
    plant = flying_plant(mechanism, None if load_modes is None else len(load_modes), stand=stand)
    modes = {} if load_modes is None else mode_values(MODE, ("frequency", "damping", "inertia"), load_modes)
    given = {**modes, **(values or {})}
    kept = {name: q for name, q in mechanism.parameters.items() if stand or not bench_reason(name)}
    kept = {name: q for name, q in kept.items() if load_modes is None or table_of(name) != MODE}
    flying = Mechanism(plant, _parameters(plant, kept, given), mechanism.options)
    for name, wrong in flying.contradictions():
        raise InputFileError(f"{name}: {wrong}")
    return flying


def without_stand(mechanism: Mechanism, values: Mapping[str, float] | None = None) -> Mechanism:
    """Return a mechanism off its test stand, on a held base, driven as on the bench: by steps or by measured channels.

    Parameters
    ----------
    mechanism : Mechanism
        As identified; its plant comes from a layout.
    values : mapping of dotted name to value
        Values that differ in flight, in the mechanism file's units.

    Raises
    ------
    InputFileError
        It comes from no mechanism file, or a value is missing or invalid.
    """
    layout = mechanism.plant.layout
    if layout is None or not measured_quantities(mechanism.plant.inputs):
        return to_flight(mechanism, values)
    own = flight_layout(layout)
    tables = own.tables | layout.tables & {DRIVE}
    driven = {name: law for name, law in layout.laws.items() if name in (DRIVE, "stepper")}
    plant = plant_of(replace(own, laws={**own.laws, **driven}, tables=tables))
    kept = {name: q for name, q in mechanism.parameters.items() if name in plant.declarations}
    flying = Mechanism(plant, _parameters(plant, kept, values or {}), mechanism.options)
    for name, wrong in flying.contradictions():
        raise InputFileError(f"{name}: {wrong}")
    return flying


def flying_plant(mechanism: Mechanism, load_modes: int | None = None, *, stand: bool = False) -> Plant:
    """Return the plant of a mechanism in flight, on a held base, with a number of flexible modes of its load.

    It may keep its test stand.

    Raises
    ------
    InputFileError
        It cannot fly: one sentence with block and remedy.
    """
    if mechanism.plant.layout is None:
        raise InputFileError("the plant was assembled by hand, from no mechanism file; only those of a file fly")
    _refuse_other_drives(mechanism)
    return plant_of(flight_layout(mechanism.plant.layout, load_modes, stand=stand))


def with_base(mechanism: Mechanism, flying: Flying, modes: ModeValues = ()) -> Mechanism:
    """Return a flying mechanism on another base; `modes` are (rad/s, damping, shape) of each structural mode.

    Raises
    ------
    InputFileError
        A block of the user's own does not describe its motion with the base.
    """
    layout = mechanism.plant.layout
    assert layout is not None
    objection = moving_base_objection(mechanism)
    if objection and flying.base is not Base.HELD:
        raise InputFileError(objection)
    plant = plant_of(replace(layout, flying=flying))
    values = mode_values("base", ("frequency", "damping", "shape"), modes)
    return Mechanism(plant, _parameters(plant, mechanism.parameters, values), mechanism.options)


def keeps_stand(mechanism: Mechanism) -> bool:
    """Return whether a mechanism in flight configuration stays on its test stand."""
    layout = mechanism.plant.layout
    return layout is not None and layout.flying is not None and layout.flying.stand


def with_ports(mechanism: Mechanism, ports: Iterable[Port]) -> Mechanism:
    """Return a mechanism with external inputs at its ports; a block of the user's own may lack one."""
    layout = mechanism.plant.layout
    assert layout is not None
    return replace(mechanism, plant=plant_of(replace(layout, ports=frozenset(ports))))


def moving_base_objection(mechanism: Mechanism) -> str:
    """Return reason and remedy, in one sentence, if a mechanism cannot stand on a moving base; else an empty string."""
    layout = mechanism.plant.layout
    if layout is None or LOAD not in layout.own:
        return ""
    return (
        f"{LOAD}: the block of your own is written for a base at rest, so that one-way is all there is; describe "
        "the load by load.inertia and [[load.mode]] of the library to join it with the structure's modes"
    )


def with_line_filter(mechanism: Mechanism, cut_off: float) -> Mechanism:
    """Return a flying mechanism that outputs its torque, and the torque below a cut-off in rad/s, without aliases."""
    lined = replace(mechanism, plant=mechanism.plant.with_outputs(("torque", LINE_TORQUE)))
    own = {CUT_OFF: cut_off, ORDER: float(LINE_ORDER)}
    declared = lined.plant.declarations
    return lined.with_parameters({n: Parameter(name=n, value=v, declaration=declared[n]) for n, v in own.items()})


def mode_values(table: str, keys: Sequence[str], modes: ModeValues) -> dict[str, float]:
    """Return dotted names and values of modes, as ``load.mode.0.frequency``."""
    return {f"{table}.{k}.{key}": v for k, mode in enumerate(modes) for key, v in zip(keys, mode, strict=True)}


def parts_left_on_bench(mechanism: Mechanism, names: Iterable[str], *, stand: bool = False) -> dict[str, str]:
    """Return the tables and estimated record parameters that do not fly, each with the reason.

    With the test stand, only the measured channels that drove the mechanism are left out.
    """
    tables = dict.fromkeys(map(table_of, mechanism.plant.declarations))
    tables = {table: None for table in tables if not stand or table == DRIVE}
    out = {f"[{table}]": TABLES[table].bench for table in tables if table in TABLES and TABLES[table].bench}
    return out | {name: RECORD for name in names if name not in mechanism.plant.declarations}


def _parameters(plant: Plant, kept: Mapping[str, Parameter], given: Mapping[str, float]) -> dict[str, Parameter]:
    """Return the parameters of a flying plant: those kept, except where values are given."""
    return {name: _parameter(plant, name, kept.get(name), given.get(name)) for name in plant.declarations}


def _parameter(plant: Plant, name: str, kept: Parameter | None, given: float | None) -> Parameter:
    declaration = plant.declarations[name]
    if given is not None:
        return Parameter(name=name, value=given, declaration=declaration)
    if kept is not None:
        return kept
    # Placeholders, which `with_line_filter` replaces.
    if name in (CUT_OFF, ORDER):
        return Parameter(name=name, value=1.0, declaration=declaration)
    if declaration.default is None and declaration.role is Role.SUPPLY:
        key = declaration.key
        raise InputFileError(
            f"{name}: on the bench measured channels drove the motor, in flight a command does; give [flight] {key}"
        )
    if declaration.default is None:
        raise InputFileError(f"{name}: missing in flight; give it in [flight] values")
    return Parameter(name=name, value=declaration.default, declaration=declaration, status=Status.KNOWN)


def _refuse_other_drives(mechanism: Mechanism) -> None:
    """Refuse a mechanism that is not driven by a step command."""
    layout, measured = mechanism.plant.layout, measured_quantities(mechanism.plant.inputs)
    assert layout is not None
    if measured and layout.laws.get("stepper") not in COMMANDED:
        raise InputFileError(
            f'assembly = "{layout.assembly}": block drive follows a measured {" and ".join(measured)}, and a mode of '
            "operation commands steps, so that it cannot fly; identify the stepper as stepper_gear_mass or "
            "current_driven_stepper"
        )
