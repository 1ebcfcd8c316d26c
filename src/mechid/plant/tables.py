"""The tables of a mechanism file: what each is for, what it chooses among, and whether it flies."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import KW_ONLY, dataclass
from functools import partial

from mechid.parameter import Role
from mechid.plant import (
    cable,
    current_limit,
    dc_motor,
    friction,
    friction_position,
    gear,
    housing,
    microstep_table,
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
        What a reader of the file is told of it.
    option : str
        Key by which it chooses its block.
    choices : collection of str
        What it chooses among, the default first; none where there is no choice.
    named : bool
        Whether the choice counts as named also where the file leaves it out.
    optional : bool
        Without the table there is no such block.
    own : bool
        Whether its block may be of the user's own.
    entry : str
        Of a list, ``[[name]]``: what one entry is called; empty of a single table.
    told_by : str
        Key of a whole number or a period that shapes the equations: what tells the entries of a list apart.
    by_value : bool
        Whether the equations take the number as a value instead, so that one kernel serves any.
    beside : str
        Dotted name of the count that makes an order of `told_by` where that is a period.
    order : int
        Of `told_by` where the file leaves it out.
    bench : str
        Why it stays on the bench when the mechanism flies; empty where it flies.
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
    beside: str = ""
    order: int = 1
    bench: str = ""
    of_record: bool = False


_harmonic = partial(Table, entry="harmonic", told_by="order")
_recorder = partial(Table, optional=True, bench=RECORDER, of_record=True)
_ALL = (
    Table(
        name="stepper",
        title="two-phase stepper motor and the voltage that drives it",
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
    Table(saliency.TABLE, "inductance of the coils over the rotor's angle", optional=True),
    Table(current_limit.TABLE, "what limits a current drive; without it currents jump", optional=True),
    Table(supply.TABLE, "source that feeds the driver; without it the voltage stands", optional=True),
    Table("friction", "dry and viscous friction of the rotor", choices=friction.LAWS, own=True),
    _harmonic(friction_position.ROTOR.table, "one harmonic of dry friction over the angle of the rotor", by_value=True),
    _harmonic(
        friction_position.OUTPUT.table, "one harmonic of dry friction over the angle of the output", by_value=True
    ),
    Table("gear", "gear, a spring and a damper seen from the output", choices=gear.LAWS, own=True),
    _harmonic("gear.kinematic_error", "one harmonic of the gear's kinematic error over the input angle"),
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
"""By name."""
LISTS = tuple(table.name for table in _ALL if table.entry)
"""Tables that are lists, ``[[name]]``."""
OPTIONAL = tuple(table.name for table in _ALL if table.optional)
"""Tables without which there is no such block."""
OWN = tuple(table.name for table in _ALL if table.own)
"""Tables whose block may be of the user's own."""
CHOICES: Mapping[str, Collection[str]] = {table.name: table.choices for table in _ALL if table.choices}
"""Tables that choose among blocks of the library, and their choices."""
OF_RECORD = tuple(table.name for table in _ALL if table.of_record)
"""Tables of which a record may have values of its own."""
MOTOR_OF_RECORD: Mapping[str, Role] = {
    "peak_voltage": Role.SUPPLY,
    "peak_current": Role.SUPPLY,
    "coil_resistance": Role.WINDING_RESISTANCE,
}
"""Keys of the motor's parameters of which a record may have a value of its own, and what these do there."""


def table_of(name: str) -> str:
    """Return the table that a parameter stands in, without the place in a list.

    Examples
    --------
    >>> table_of("stepper.detent.0.amplitude"), table_of("gear.stiffness"), table_of("record.slow.time_offset_s")
    ('stepper.detent', 'gear', 'record.slow')
    """
    table = name.rpartition(".")[0]
    head, _, last = table.rpartition(".")
    return head if last.isdigit() else table


def bench_reason(name: str) -> str:
    """Return why a parameter's table stays on the bench, empty where it flies."""
    known = TABLES.get(table_of(name))
    return known.bench if known else ""
