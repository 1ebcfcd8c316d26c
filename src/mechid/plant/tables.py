"""Tables of a mechanism file: title, choices, and whether they belong to the flying mechanism."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import KW_ONLY, dataclass
from functools import partial

from mechid.parameter import Role
from mechid.plant import (
    cable,
    chopper,
    current_limit,
    dc_motor,
    detent_hysteresis,
    friction,
    friction_position,
    gear,
    gear_laws,
    gear_mesh,
    housing,
    magnet,
    microstep_table,
    pulses,
    saliency,
    supply,
    test_stand,
)
from mechid.plant.drive import CURRENTS, VOLTAGES

HOUSING = "its filter has no reaction on the mechanism; a mode of the real housing belongs into the structure"
RECORDER = "it belongs to the test stand, which is no part of the mechanism"


@dataclass(frozen=True)
class Table:
    """One table of the mechanism file.

    Parameters
    ----------
    name : str
        Dotted, e.g. ``"stepper.detent"``.
    title : str
        Description for a reader of the file.
    option : str
        Key that selects its block.
    choices : collection of str
        Values of that key, the default first; empty if there is no choice.
    named : bool
        Whether the default counts as named if the file leaves it out.
    optional : bool
        Whether the block is absent without the table.
    own : bool
        Whether a block of the user's own may replace its block.
    entry : str
        Name of one entry of a list, ``[[name]]``; empty for a single table.
    told_by : str
        Key of an integer or a period that shapes the equations and distinguishes the entries of a list.
    by_value : bool
        Whether the equations take that number as a value, so that one kernel serves any.
    fractions : bool
        Whether that number may be a fraction, as the order of a tooth mesh is; the equations then take it as a value.
    beside : str
        Dotted name of the count that converts `told_by` to an order, if it is a period.
    order : int
        Default of `told_by`.
    bench : str
        Reason why it stays on the bench; empty if it flies.
    of_record : bool
        Whether records may have values of their own.
    """

    name: str
    title: str
    _: KW_ONLY
    option: str = "law"
    choices: Collection[str] = ()
    named: bool = False
    optional: bool = False
    own: bool = False
    entry: str = ""
    told_by: str = ""
    by_value: bool = False
    fractions: bool = False
    beside: str = ""
    order: int = 1
    bench: str = ""
    of_record: bool = False


_harmonic = partial(Table, entry="harmonic", told_by="order")
_recorder = partial(Table, optional=True, bench=RECORDER, of_record=True)
_ALL = (
    Table(
        name="stepper",
        title="stepper motor and the voltage that drives it",
        option="drive",
        choices=(*VOLTAGES, *CURRENTS),
    ),
    Table(
        name="stepper.detent",
        title="one harmonic of the detent torque: amplitude * sin(360 deg * angle / period + phase)",
        entry="harmonic",
        told_by="period_deg",
        beside="stepper.poles",
    ),
    _harmonic("stepper.torque_harmonic", "one harmonic of the torque constant over the electrical angle"),
    _harmonic(
        microstep_table.TABLE,
        "one harmonic of the error of the driver's microstep table, over the commanded electrical angle",
    ),
    Table("stepper.imbalance", "phase A and phase B apart", optional=True),
    Table(detent_hysteresis.TABLE, "hysteresis of the detent torque", optional=True),
    Table(magnet.TABLE, "magnet of the rotor over temperature", optional=True),
    Table(saliency.TABLE, "inductance of the coils over the rotor's angle", optional=True),
    Table(current_limit.TABLE, "what limits a current drive; without it currents jump", optional=True),
    Table(
        chopper.TABLE,
        "chopper of a current drive, switch by switch; without it its average",
        option=chopper.OPTION,
        choices=chopper.DECAYS,
        optional=True,
        bench="a budget and linear models have the average of a chopper",
    ),
    Table(
        pulses.TABLE,
        "pulse of the driver after each step; without it the phases are held from step to step",
        option=pulses.OPTION,
        choices=pulses.LAWS,
        optional=True,
    ),
    Table(supply.TABLE, "source that feeds the driver; without it the voltage stands", optional=True),
    Table("friction", "dry and viscous friction of the rotor", choices=friction.LAWS, own=True),
    _harmonic(friction_position.ROTOR.table, "one harmonic of dry friction over the angle of the rotor", by_value=True),
    *(
        _harmonic(one.table, f"one harmonic of dry friction {one.mode} over the angle of the rotor", by_value=True)
        for one in (friction_position.FORWARD, friction_position.BACKWARD)
    ),
    _harmonic(
        friction_position.OUTPUT.table, "one harmonic of dry friction over the angle of the output", by_value=True
    ),
    Table("gear", "gear, a spring and a damper seen from the output", choices=gear_laws.LAWS, own=True),
    _harmonic(gear.ERROR, "one harmonic of the gear's kinematic error over the input angle", fractions=True),
    _harmonic(
        gear.STIFFNESS, "one harmonic of the gear's stiffness over the input angle", by_value=True, fractions=True
    ),
    Table(gear_mesh.TABLE, "two wheels of the gear; the next mesh follows it", entry="mesh"),
    Table("load", "test mass on the output", own=True),
    Table("load.mode", "one flexible mode of the load", entry="mode"),
    Table(
        name="load.unbalance",
        title="weight of the load off its axis: amplitude * sin(angle of the load + phase)",
        optional=True,
        bench="it is the load's weight, and in orbit nothing weighs",
    ),
    Table("load.cable", "cables from the base to the load", choices=cable.LAWS, optional=True),
    Table("output_friction", "dry and viscous friction of the load", optional=True, own=True),
    Table("motor", "the motor's side"),
    Table(dc_motor.SPRING, "spring from the motor's shaft to its base", optional=True),
    Table(
        name="housing",
        title="resonance of the housing; without this table the housing is rigid",
        option="form",
        choices=housing.FORMS,
        named=True,
        optional=True,
        own=True,
        bench=HOUSING,
    ),
    Table(
        housing.SECOND.table, "second resonance of the housing, which adds to the first", optional=True, bench=HOUSING
    ),
    _recorder("transducer", "the torque transducer", choices=test_stand.TRANSDUCERS),
    _recorder("charge_amplifier", "high-pass of the charge amplifier"),
    _recorder("anti_alias", "low-pass of the recorder", told_by="order", order=4),
    Table("drive", "what drives it is a measured channel of each record", bench=RECORDER, of_record=True),
)

TABLES: Mapping[str, Table] = {table.name: table for table in _ALL}
"""Tables by name."""
LISTS = tuple(table.name for table in _ALL if table.entry)
"""Tables that are lists, ``[[name]]``."""
OPTIONAL = tuple(table.name for table in _ALL if table.optional)
"""Tables whose block is absent without them."""
OWN = tuple(table.name for table in _ALL if table.own)
"""Tables whose block a block of the user's own may replace."""
CHOICES: Mapping[str, Collection[str]] = {table.name: table.choices for table in _ALL if table.choices}
"""Tables that select a block of the library, and their choices."""
OF_RECORD = tuple(table.name for table in _ALL if table.of_record)
"""Tables for which a record may have values of its own."""
MOTOR_OF_RECORD: Mapping[str, Role] = {
    "peak_voltage": Role.SUPPLY,
    "peak_current": Role.SUPPLY,
    "coil_resistance": Role.WINDING_RESISTANCE,
    magnet.RISE: Role.TEMPERATURE,
}
"""Keys of the motor's parameters for which a record may have a value of its own, with their roles."""


def table_of(name: str) -> str:
    """Return the table of a parameter, without the position in a list.

    Examples
    --------
    >>> table_of("stepper.detent.0.amplitude"), table_of("gear.stiffness"), table_of("record.slow.time_offset_s")
    ('stepper.detent', 'gear', 'record.slow')
    """
    table = name.rpartition(".")[0]
    head, _, last = table.rpartition(".")
    return head if last.isdigit() else table


def bench_reason(name: str) -> str:
    """Return the reason why a parameter's table stays on the bench; empty if it flies."""
    known = TABLES.get(table_of(name))
    return known.bench if known else ""
