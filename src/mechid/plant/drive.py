"""Drives: phase voltages, phase currents or a torque from the command or from measured channels."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

from sympy import Expr, Integer, Symbol, symbols

from mechid.errors import InputFileError
from mechid.parameter import Declaration, Role
from mechid.plant import microstep_table
from mechid.plant.block import Block
from mechid.plant.harmonic import coordinates_of
from mechid.plant.microstep_table import WAVEFORMS
from mechid.plant.phases import STAR, axes_of_two

RAMP = "_slope"
"""Suffix of the second input of a measured channel: the first is its value at a sample, this its slope to the next."""


def voltage_drive(table_orders: Sequence[int] = (), phases: int = 2) -> Block:
    """Ideal voltage source without current control: u_A = U e_A, u_B = U e_B.

    The normalised waveforms e_A = -cos(theta_k), e_B = sin(theta_k) come from the command and are
    held from step to step; u in V. Section 3.1 of [Kornienko2013]_. An error of the microstep table adds a
    perpendicular component delta(theta_k), which rotates them (`microstep_table`).

    Parameters
    ----------
    table_orders : sequence of int
        Harmonics of that error.
    phases : {2, 3, 4}
        Number of phases; A and B are the axes of three in star (`phases`), whose waveforms the command transforms.
    """
    U, u_A, u_B = symbols("U u_A u_B")
    errors, (given_A, given_B) = microstep_table.harmonics(table_orders), microstep_table.driver_waveforms(table_orders)
    return Block(
        name="drive",
        table="stepper",
        declarations=(
            Declaration(
                key="peak_voltage",
                symbol="U",
                unit="V",
                meaning="peak phase voltage",
                lower=0.0,
                source="not in the paper; 0.6 A x 9.5 ohm comes near its amplitudes",
                role=Role.SUPPLY,
                supply_power=1,
            ),
            *(d for e in errors for d in e.declarations),
        ),
        coordinates=coordinates_of(errors),
        polar=tuple(e.polar for e in errors),
        inputs=WAVEFORMS,
        terms={**microstep_table.error(table_orders), u_A: U * given_A, u_B: U * given_B},
        outputs={"u_A": u_A, "u_B": u_B, "duty_A": given_A, "duty_B": given_B},
        extensions=microstep_table.extensions(table_orders),
    )


def current_drive(table_orders: Sequence[int] = (), phases: int = 2) -> Block:
    """Ideal current source, i.e. a chopper drive without its ripple: i_A = I e_A, i_B = I e_B.

    The waveforms are those of `voltage_drive`; i in A. A chopper switches about 10^4 times a second around its
    set point, far faster than a mechanism responds, so neither the ripple nor the rise of the current is modelled.
    `table_orders` and `phases` are as for `voltage_drive`.
    """
    current, i_A, i_B = symbols("I_peak i_A i_B")
    errors, (given_A, given_B) = microstep_table.harmonics(table_orders), microstep_table.driver_waveforms(table_orders)
    return Block(
        name="drive",
        table="stepper",
        declarations=(
            Declaration(
                key="peak_current",
                symbol="I_peak",
                unit="A",
                meaning="peak phase current",
                lower=0.0,
                source="the drive's setting",
                role=Role.SUPPLY,
                supply_power=1,
            ),
            *(d for e in errors for d in e.declarations),
        ),
        coordinates=coordinates_of(errors),
        polar=tuple(e.polar for e in errors),
        inputs=WAVEFORMS,
        terms={**microstep_table.error(table_orders), i_A: current * given_A, i_B: current * given_B},
        outputs={"i_A": i_A, "i_B": i_B},
        extensions=microstep_table.extensions(table_orders),
        reference="ideal source",
    )


def measured_drive(channels: Sequence[tuple[str, str]], table: str, offset: Declaration | None = None) -> Block:
    """Measured channels as inputs, held or interpolated linearly between samples: v = value + ramp.

    Each channel is two inputs of the plant, its value v_k held from a sample on and its slope; `ramp` integrates
    the slope. A linear interpolation consists of the first value and the slopes; held samples have slope 0.

    Parameters
    ----------
    channels : sequence of (str, str)
        Quantity of each channel and the name of the output it becomes, e.g. ``("voltage_phase_a", "u_A")``.
    table : str
        Table of the mechanism file.
    offset : Declaration or None
        Constant that is added to every channel.
    """
    added = Symbol(offset.symbol) if offset else 0
    ramps = {quantity: Symbol(f"{quantity}_ramp") for quantity, _ in channels}
    slopes = {quantity: Symbol(f"{quantity}{RAMP}") for quantity, _ in channels}
    outputs: dict[str, Expr] = {name: Symbol(quantity) + ramps[quantity] + added for quantity, name in channels}
    return Block(
        name="drive",
        table=table,
        declarations=(offset,) if offset else (),
        inputs=tuple(s for quantity, _ in channels for s in (Symbol(quantity), slopes[quantity])),
        terms={Symbol(name): value for name, value in outputs.items()},
        rates={ramps[quantity]: slopes[quantity] for quantity, _ in channels},
        initial=dict.fromkeys(ramps.values(), Integer(0)),
        outputs={name: Symbol(name) for name in outputs},
        reference="measured",
    )


def measured_quantities(inputs: Sequence[Symbol]) -> tuple[str, ...]:
    """Return the quantities of the measured channels among a plant's inputs; none if a command drives it."""
    names = [s.name for s in inputs]
    return tuple(name for name in names if f"{name}{RAMP}" in names)


def _measured_phases(quantity: str, letter: str) -> Drive:
    """Return the drive for two measured phases, which admits no microstep table."""

    def drive(table_orders: Sequence[int] = (), phases: int = 2) -> Block:
        if table_orders:
            raise InputFileError(
                f"{microstep_table.TABLE}: measured channels drive the phases, the driver's table in them; delete it"
            )
        block = measured_drive([(f"{quantity}_phase_{x}", f"{letter}_{x.upper()}") for x in "ab"], "stepper")
        return _on_axes(block, letter) if phases == STAR else block

    return drive


def _on_axes(block: Block, letter: str) -> Block:
    """Return a drive whose outputs are the axes of a star, from the measured values of its phases A and B."""
    first, second = (Symbol(f"{letter}_{x}") for x in "AB")
    return replace(block, outputs={f"{letter}_{x}": e for x, e in axes_of_two(first, second).items()})


Drive: TypeAlias = Callable[[Sequence[int], int], Block]
VOLTAGES: Mapping[str, Drive] = {"voltage": voltage_drive, "measured_voltage": _measured_phases("voltage", "u")}
CURRENTS: Mapping[str, Drive] = {"current": current_drive, "measured_current": _measured_phases("current", "i")}
"""Drives of a stepper by their names in mechanism.toml: voltage drives and current drives."""
COMMANDED: Mapping[str, str] = {"measured_voltage": "voltage", "measured_current": "current"}
"""The commanded drive that corresponds to a drive with measured channels."""
