"""Drives: what the command, or a measured channel, makes of phase voltages, phase currents, or a torque."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

from sympy import Expr, Integer, Symbol, symbols

from mechid.errors import InputFileError
from mechid.parameter import Declaration, Role
from mechid.plant import microstep_table
from mechid.plant.block import Block
from mechid.plant.harmonic import coordinates_of
from mechid.plant.microstep_table import WAVEFORMS

RAMP = "_slope"
"""A measured input comes as two: its value held from a sample on, and its slope from there to the next."""


def voltage_drive(table_orders: Sequence[int] = ()) -> Block:
    """Ideal voltage source without current control: u_A = U e_A, u_B = U e_B.

    The normalised waveforms e_A = -cos(theta_k), e_B = sin(theta_k) come from the command and are
    held from step to step; u in V. Section 3.1 of [Kornienko2013]_. With an error of the microstep table
    delta(theta_k) of them stands across, which turns them further (`microstep_table`).

    Parameters
    ----------
    table_orders : sequence of int
        Harmonics of that error.
    """
    U, u_A, u_B = symbols("U u_A u_B")
    errors, (given_A, given_B) = microstep_table.harmonics(table_orders), microstep_table.given(table_orders)
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


def current_drive(table_orders: Sequence[int] = ()) -> Block:
    """Ideal current source, what a chopper drive is behind its ripple: i_A = I e_A, i_B = I e_B.

    The waveforms are those of `voltage_drive`; i in A. A chopper switches some 10^4 times a second about its
    set point, far above what a mechanism follows, so neither the ripple nor the rise of the current is modelled.
    `table_orders` is as for `voltage_drive`.
    """
    current, i_A, i_B = symbols("I_peak i_A i_B")
    errors, (given_A, given_B) = microstep_table.harmonics(table_orders), microstep_table.given(table_orders)
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
    """Measured channels as they are, held from sample to sample or straight between samples: v = value + ramp.

    Each channel is two inputs of the plant, its value v_k held from a sample on and its slope; `ramp` integrates
    the slope. Straight lines between samples are the first value and the slopes; held samples have no slope.

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
    """Return the quantities of the channels that drive a plant of such inputs; none where a command does."""
    names = [s.name for s in inputs]
    return tuple(name for name in names if f"{name}{RAMP}" in names)


def _measured(quantity: str, letter: str) -> Drive:
    """Return the drive of two measured phases, which knows no microstep table."""

    def drive(table_orders: Sequence[int] = ()) -> Block:
        if table_orders:
            raise InputFileError(
                f"{microstep_table.TABLE}: measured channels drive the phases, the driver's table in them; delete it"
            )
        return measured_drive([(f"{quantity}_phase_{x}", f"{letter}_{x.upper()}") for x in "ab"], "stepper")

    return drive


Drive: TypeAlias = Callable[[Sequence[int]], Block]
VOLTAGES: Mapping[str, Drive] = {"voltage": voltage_drive, "measured_voltage": _measured("voltage", "u")}
CURRENTS: Mapping[str, Drive] = {"current": current_drive, "measured_current": _measured("current", "i")}
"""Drives of a stepper by the name in mechanism.toml, of its voltages and of its currents."""
COMMANDED: Mapping[str, str] = {"measured_voltage": "voltage", "measured_current": "current"}
"""The drive that a step command acts through, in place of one that follows measured channels."""
