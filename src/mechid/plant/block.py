"""Building blocks of a plant: equations with their parameters, and their switching behaviour.

A block is a value. It names its inputs by symbols of its own; an assembly wires them to the
outputs of other blocks (`assembly.py`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import sympy as sp

from mechid.parameter import Declaration


@dataclass(frozen=True, kw_only=True)
class Guard:
    """A margin that is positive while its mode holds; the mode ends when it reaches zero.

    Parameters
    ----------
    margin : Expr
        Function of states, parameters, inputs and terms of the plant.
    target : str or None
        The next mode; None selects it by the switch's `entry` rules.
    resets : mapping of state to number
        States that take a fixed value there.
    """

    margin: sp.Expr
    target: str | None = None
    resets: Mapping[sp.Symbol, float] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Switch:
    """A set of modes, the symbols whose values distinguish them, and the guards that end them.

    Parameters
    ----------
    name : str
    modes : mapping of mode name to {symbol: value}
        Each mode gives each of the switch's symbols a number; the equations use the symbols.
    guards : mapping of mode name to tuple of Guard
    entry : tuple of (Expr, mode name)
        Tried in order; the first positive expression selects the mode, at the start and after a
        guard without a target.
    otherwise : str
        The mode if no entry rule applies.
    ideal : mapping of Symbol to float
        Values of the symbols with the switch removed, e.g. without friction.
    """

    name: str
    modes: Mapping[str, Mapping[sp.Symbol, float]]
    guards: Mapping[str, tuple[Guard, ...]]
    entry: tuple[tuple[sp.Expr, str], ...]
    otherwise: str
    ideal: Mapping[sp.Symbol, float] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class PolarPair:
    """An amplitude and a phase in the file, which the kernel represents by a cosine and a sine part.

    The kernel's parameters are K cos(phi) and K sin(phi), which stay well-defined at K = 0. `cycles` is the number of
    periods per turn of the rotor, in the file's symbols. `of_phase` marks a harmonic of the motor's phases, which stays
    in place when the zero of the rotor angle is moved.
    """

    amplitude: str
    phase: str
    cosine: sp.Symbol
    sine: sp.Symbol
    cycles: sp.Expr
    of_phase: bool = False


@dataclass(frozen=True)
class NamedOrder:
    """A periodic cause of disturbance with a name: its periods per turn of the rotor, or per second.

    Parameters
    ----------
    name : str
        Name by which a mechanism file refers to the order, e.g. ``"mesh 1"``.
    words : str
        Plain description; ``{key}`` stands for a value.
    cycles : Expr
        Periods per turn of the rotor, in the file's symbols; need not be a whole number.
    values : mapping of key to Expr
        Values that `words` names, in the file's symbols.
    per_second : bool
        Whether `cycles` are those per second, as of a clock; none if they are zero.
    """

    name: str
    words: str
    cycles: sp.Expr
    values: Mapping[str, sp.Expr] = field(default_factory=dict)
    per_second: bool = False


@dataclass(frozen=True, kw_only=True)
class Agreement:
    """A condition that two quantities of a mechanism file are equal.

    Parameters
    ----------
    name : str
        Dotted name at which a contradiction is reported.
    value, wanted : Expr
        The two quantities, in the file's symbols.
    within : float
        Relative difference up to which they count as equal.
    words : str
        Message with its remedy; ``{value}``, ``{wanted}`` and ``{missing}`` = wanted / value stand for numbers.
    """

    name: str
    value: sp.Expr
    wanted: sp.Expr
    within: float
    words: str


@dataclass(frozen=True, kw_only=True)
class Extension:
    """A term that a real block may have and the mechanism file may lack; at its null value it vanishes.

    Parameters
    ----------
    name : str
        Name of the term, e.g. ``"gear.kinematic_error:2"``; of a list whose entries differ by period
        ``"stepper.detent"``, to which the period is appended. Extensions of the same name are added together.
    words : str
        Plain description of the effect for a report; ``{key}`` stands for the value of a key of `structure`.
    table : str
        Table of the mechanism file that would contain it.
    order : int or None
        The order that distinguishes entries of a list; None for a single table.
    law : str
        Law that the table has to name; empty if it chooses none.
    structure : mapping of key to Expr
        Values of the entry's keys that shape the equations, in the file's symbols.
    widths : mapping of key to Expr
        Its free parameters with their typical magnitude: standard deviation about the null value, in the file's
        unit and symbols. An amplitude covers both parts of its pair; keys left out stay at their null value.
    grown : bool
        Whether it is among the terms that are freed from zero if plain growth stalls; too many of them spoil it.
    rarer : bool
        Whether it is freed only if the usual terms do not suffice.
    values : mapping of key to Expr
        Further values that `words` names, in the file's symbols.
    """

    name: str
    words: str
    table: str
    order: int | None = None
    law: str = ""
    structure: Mapping[str, sp.Expr] = field(default_factory=dict)
    widths: Mapping[str, sp.Expr] = field(default_factory=dict)
    grown: bool = True
    rarer: bool = False
    values: Mapping[str, sp.Expr] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Series:
    """Extensions of one kind with any integer number of periods per turn, in addition to those listed.

    Parameters
    ----------
    per_step : Expr
        Turns per full step of the motor, in the file's symbols.
    entry : callable
        Maps a number of periods per turn, at least 1, to the extension.
    most : int
        Largest number of periods per turn that growth tries; 0 for none.
    is_line : bool
        Whether it leaves a spectral line at its periods in the misfit; a factor on a switching torque leaves many.
    """

    per_step: sp.Expr
    entry: Callable[[int], Extension]
    most: int = 0
    is_line: bool = True


@dataclass(frozen=True, kw_only=True)
class Rival:
    """An alternative law or table that a real block may have and that no null value leads to.

    Parameters
    ----------
    name : str
        Name of the alternative, e.g. ``"friction.stribeck"``.
    words : str
        Plain description of the effect for a report.
    table : str
        Table of the mechanism file that names the law, or that comes with it.
    law : str
        Empty if the table itself is the alternative.
    order : int or None
        Order of a table that is shaped by one.
    free : mapping of key to (Expr, Expr, Expr)
        Its free parameters: start, minimum and maximum, in the file's unit and symbols.
    null : str
        Key of an amplitude in `free`: at 0 the effect vanishes whatever the other values, and the derivative with
        respect to it shows whether the effect is present. Empty if there is none.
    size : str
        Key in `free` without a derivative at 0, such as a play: at the lower end of its range the effect is absent.
    tried : mapping of key to tuple of float
        Values of another key at which that derivative is evaluated.
    grown : bool
        Whether it is among the alternatives that are tried with starts of their own if growth stalls.
    imitated_by : str
        A disturbance of the records that mimics its absence, as ``"record.delay"`` mimics a missing low-pass.
    hides : bool
        Whether a fit without it may leave nothing but noise and yet be wrong, so that it is tested then too: from
        `null`, or from a start so close to zero that a linear fit detects it.
    """

    name: str
    words: str
    table: str
    law: str = ""
    order: int | None = None
    free: Mapping[str, tuple[sp.Expr, sp.Expr, sp.Expr]] = field(default_factory=dict)
    null: str = ""
    size: str = ""
    tried: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    grown: bool = True
    imitated_by: str = ""
    hides: bool = False


@dataclass(frozen=True, kw_only=True)
class LinearSystem:
    """A linear filter behind the plant, x' = A x + B u, solved in closed form in the time loop.

    Parameters
    ----------
    states : tuple of Symbol, (n,)
    inputs : tuple of Symbol, (m,)
        Terms of the plant.
    A, B : Matrix, (n, n) and (n, m)
        Functions of the parameters alone.
    """

    states: tuple[sp.Symbol, ...]
    inputs: tuple[sp.Symbol, ...]
    A: sp.Matrix
    B: sp.Matrix


@dataclass(frozen=True, kw_only=True)
class Block:
    """One piece of hardware: parameters, terms, rates, and outputs to other blocks.

    Parameters
    ----------
    name : str
        Name in the wiring, e.g. ``"rotor"``.
    table : str
        Table of the mechanism file that holds its parameters, e.g. ``"gear"``.
    declarations : tuple of Declaration
        Parameters as named in the file; several blocks may read one table.
    coordinates : mapping of Symbol to Expr
        Kernel parameters that differ from the values of the file, as functions of the file's symbols.
    polar : tuple of PolarPair
    inputs : tuple of Symbol
        Symbols that the wiring supplies.
    terms : mapping of Symbol to Expr
        Named quantities; the kernel keeps their names.
    rates : mapping of state to Expr
        Time derivatives.
    initial : mapping of state to Expr
        States at the start of a record, including those of the filter; missing states of the filter start at 0.
    starts : tuple of Declaration
        Start values that a record may have of its own: symbols of `initial` that are zero otherwise (`plant.start`).
    outputs : mapping of str to Expr
        Outputs to which other blocks may be wired.
    switch : Switch or None
    filter : LinearSystem or None
    swinging : mapping of state to str
        Name of the oscillating part for a resonance that moves that state most. The default is the block's name; an
        empty name marks a state that does not oscillate, as in a low-pass.
    scales : mapping of str to Expr
        Quantities of its data sheet, as ``"holding torque"``: functions of the file's symbols.
    extensions : tuple of Extension
        Additional terms that it may have, smooth at their null values.
    series : tuple of Series
        Additional terms with other periods.
    named_orders : tuple of NamedOrder
        Periodic causes that its data sheet states, whether or not an equation has them.
    agreements : tuple of Agreement
        Conditions between its parameters.
    rivals : tuple of Rival
        Alternatives without a null value; further starts of one alternative are further entries.
    reference : str
        Source of the equations.
    """

    name: str
    table: str
    declarations: tuple[Declaration, ...] = ()
    coordinates: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)
    polar: tuple[PolarPair, ...] = ()
    inputs: tuple[sp.Symbol, ...] = ()
    terms: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)
    rates: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)
    initial: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)
    starts: tuple[Declaration, ...] = ()
    outputs: Mapping[str, sp.Expr] = field(default_factory=dict)
    switch: Switch | None = None
    filter: LinearSystem | None = None
    swinging: Mapping[sp.Symbol, str] = field(default_factory=dict)
    scales: Mapping[str, sp.Expr] = field(default_factory=dict)
    extensions: tuple[Extension, ...] = ()
    series: tuple[Series, ...] = ()
    named_orders: tuple[NamedOrder, ...] = ()
    agreements: tuple[Agreement, ...] = ()
    rivals: tuple[Rival, ...] = ()
    reference: str = "Kornienko2013"
