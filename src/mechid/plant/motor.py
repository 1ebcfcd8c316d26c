"""Motor of a stepper's assembly: drive, windings and detents, their wiring, and the quantities of its phases."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from mechid.errors import InputFileError
from mechid.plant import chopper, current_limit, detent_hysteresis, magnet, microstep_table, pulses, saliency, supply
from mechid.plant.block import Block
from mechid.plant.detent import detent
from mechid.plant.drive import CURRENTS, VOLTAGES
from mechid.plant.layout import Layout, Parts
from mechid.plant.phases import HARMONIC, STAR, check_star, scales_of
from mechid.plant.ports import Port, add_phase_ports
from mechid.plant.stepper import PHASES, current_fed, motor_torque, windings


def stepper_parts(layout: Layout, drive: str) -> Parts:
    """Return drive, windings, detents and their sum, their wiring, and the quantities of the phases."""
    orders, holding = layout.orders.get("stepper.detent", ()), scales_of(drive, layout.phases)[0]
    phases, wiring, measured = _phases(layout, drive)
    detents = [detent(k, order, holding) for k, order in enumerate(orders)]
    lagging, warm = detent_hysteresis.TABLE in layout.tables, magnet.TABLE in layout.tables
    detents += [detent_hysteresis.hysteresis()] * lagging + [magnet.magnet()] * warm
    return [*phases, *detents, motor_torque(orders, holding, lagging=lagging, warm=warm)], wiring, measured


def _phases(layout: Layout, drive: str) -> Parts:
    """Return drive and windings, their wiring, and the quantities of the phases."""
    check_star(layout.phases, (*layout.tables, *layout.orders))
    pulses.check_pulses(layout, drive)
    _check_drive(layout, drive)
    decay = chopper.check_chopper(layout)
    harmonics, table_orders = layout.whole_orders(HARMONIC), layout.whole_orders(microstep_table.TABLE)
    apart, sagging = "stepper.imbalance" in layout.tables, supply.TABLE in layout.tables
    source = _with_ports({**VOLTAGES, **CURRENTS}[drive](table_orders, layout.phases), layout)
    if law := pulses.law_of(layout):
        source = pulses.declare_pulses(source, layout, drive)
        if law != pulses.HELD:
            return pulses.pulsed_motor(source, harmonics, layout.phases, law)
    if drive in VOLTAGES:
        coils = windings(
            harmonics=harmonics,
            apart=apart,
            salient=saliency.TABLE in layout.tables,
            sagging=sagging,
            commanded=drive == "voltage",
            phases=layout.phases,
        )
        terminals = drive == "voltage" and not sagging and layout.phases != STAR
        voltages = {f"voltage_phase_{x.lower()}": f"drive.u_{x}" for x in PHASES} if terminals else {}
        return [source, coils], {}, {**_currents(layout, dict.fromkeys(PHASES, "windings")), **voltages}
    limited = current_limit.TABLE in layout.tables
    coils = current_fed(
        harmonics=harmonics, apart=apart, limited=limited, commanded=drive == "current", phases=layout.phases
    )
    if not limited:
        return [source, coils], {}, _currents(layout, dict.fromkeys(PHASES, "drive"))
    wiring = {f"loop_{x}.i_ref_{x}": f"drive.i_{x}" for x in PHASES}
    wiring |= {f"windings.i_{x}": f"loop_{x}.i_{x}" for x in PHASES}
    loops = map(partial(chopper.chopped_loop, decay=decay) if decay else current_limit.loop, PHASES)
    voltages = {f"voltage_phase_{x.lower()}": f"loop_{x}.v_{x}" for x in PHASES} if decay else {}
    return [source, coils, *loops], wiring, {**_currents(layout, {x: f"loop_{x}" for x in PHASES}), **voltages}


def _check_drive(layout: Layout, drive: str) -> None:
    """Refuse tables that belong to another drive."""
    if saliency.TABLE in layout.tables and drive not in VOLTAGES:
        raise InputFileError(f'{saliency.TABLE}: drive = "{drive}" knows no inductance; delete the table')
    if supply.TABLE in layout.tables and drive != "voltage":
        raise InputFileError(f'{supply.TABLE}: drive = "{drive}" does not see what its source does; delete the table')
    if current_limit.TABLE in layout.tables and drive != "current":
        raise InputFileError(f'{current_limit.TABLE}: belongs to drive = "current", found "{drive}"; delete the table')


def _currents(layout: Layout, where: Mapping[str, str]) -> dict[str, str]:
    """Return the currents of the phases, from the block of each."""
    if layout.phases == STAR:
        return {f"current_phase_{x}": f"windings.i_phase_{x}" for x in "abc"}
    return {f"current_phase_{x.lower()}": f"{where[x]}.i_{x}" for x in PHASES}


def _with_ports(drive: Block, layout: Layout) -> Block:
    return add_phase_ports(drive) if Port.PHASES in layout.ports else drive
