"""What a block is: equations beside their parameters, and the hybrid part beside the smooth one.

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
    """A margin that stays positive while its mode holds; where it reaches zero the mode ends.

    Parameters
    ----------
    margin : Expr
        Function of states, parameters, inputs and terms of the plant.
    target : str or None
        The mode that follows; None asks the switch's `entry` rules.
    resets : mapping of state to number
        States that take a fixed value there.
    """

    margin: sp.Expr
    target: str | None = None
    resets: Mapping[sp.Symbol, float] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Switch:
    """A set of modes, the symbols whose values tell them apart, and the guards that end them.

    Parameters
    ----------
    name : str
    modes : mapping of mode name to {symbol: value}
        Each mode gives each of the switch's symbols a number; the equations use the symbols.
    guards : mapping of mode name to tuple of Guard
    entry : tuple of (Expr, mode name)
        Tried in order, the first positive expression wins: the mode at start, and after a
        guard without a target.
    otherwise : str
        The mode where no entry rule holds.
    ideal : mapping of Symbol to float
        Values of the symbols as if the switch were not there, e.g. without friction.
    """

    name: str
    modes: Mapping[str, Mapping[sp.Symbol, float]]
    guards: Mapping[str, tuple[Guard, ...]]
    entry: tuple[tuple[sp.Expr, str], ...]
    otherwise: str
    ideal: Mapping[sp.Symbol, float] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class PolarPair:
    """An amplitude and a phase of the file that the kernel knows as cosine and sine part.

    The kernel's parameters are K cos(phi) and K sin(phi): at K = 0 the phase is not dead. `cycles` is how many
    periods it has in a turn of the rotor, in the file's symbols. `of_phase` says that it belongs to the motor's
    phases, so that it stays where it is when the rotor's zero is put elsewhere.
    """

    amplitude: str
    phase: str
    cosine: sp.Symbol
    sine: sp.Symbol
    cycles: sp.Expr
    of_phase: bool = False


@dataclass(frozen=True, kw_only=True)
class Extension:
    """A term that a real block may have and a mechanism file may lack; at its null value it is not there.

    Parameters
    ----------
    name : str
        What it is called, e.g. ``"gear.kinematic_error:2"``; of a list told apart by periods ``"stepper.detent"``, to
        which the period is added. Those of one name are there together.
    words : str
        What the effect is, in a plain phrase for a report; ``{key}`` is the value of a key of `structure`.
    table : str
        Table of the mechanism file that it would stand in.
    order : int or None
        Of a list, what tells its entries apart; None of a table that is there once.
    law : str
        That the table names to have it; empty where it chooses none.
    structure : mapping of key to Expr
        Values of the entry's keys that shape the equations, in the file's symbols.
    widths : mapping of key to Expr
        What is free of it, each with how large it may well be: standard deviation about the null value, in the file's
        unit and symbols. An amplitude stands for both parts of its pair; what is left out stays at its null.
    grown : bool
        Whether it is among those that are freed from nothing where plain growth stalls; too many of them spoil it.
    rarer : bool
        Whether it is freed only where the usual ones do not suffice.
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


@dataclass(frozen=True, kw_only=True)
class Series:
    """Extensions of one kind with any whole number of periods in a turn, beyond those that are listed.

    Parameters
    ----------
    per_step : Expr
        Turns in a full step of the motor, in the file's symbols.
    entry : callable
        From a number of periods in a turn, at least 1, to the extension.
    most : int
        Periods in a turn up to which growth looks for one; 0 where it does not.
    is_line : bool
        Whether a misfit has a spectral line at its periods; one that multiplies a switching torque has many lines.
    """

    per_step: sp.Expr
    entry: Callable[[int], Extension]
    most: int = 0
    is_line: bool = True


@dataclass(frozen=True, kw_only=True)
class Rival:
    """A law or a table that a real block may have in place of what is chosen, and that no null value leads to.

    Parameters
    ----------
    name : str
        What it is called, e.g. ``"friction.stribeck"``.
    words : str
        What the effect is, in a plain phrase for a report.
    table : str
        Table of the mechanism file that names the law, or that is there with it.
    law : str
        Empty where the table itself is what may be there.
    order : int or None
        Of a table that an order shapes.
    free : mapping of key to (Expr, Expr, Expr)
        What is free of it: a start, the least and the most, in the file's unit and symbols.
    null : str
        Of `free`, the key of an amplitude: at 0 there is nothing of it, whatever the others are, and its derivative
        says whether there should be. Empty where it has none.
    tried : mapping of key to tuple of float
        Values of another key at which that derivative is to be looked at.
    grown : bool
        Whether it is among those that are tried with starts of their own where growth stalls.
    imitated_by : str
        A disturbance of the records that takes its place where it is lacking, as ``"record.delay"`` a low-pass's.
    hides : bool
        Whether a fit without it may leave no more than noise and yet be wrong, so that it is looked for there too: from
        `null`, or from a start so near to nothing that a linear fit says whether it is there.
    """

    name: str
    words: str
    table: str
    law: str = ""
    order: int | None = None
    free: Mapping[str, tuple[sp.Expr, sp.Expr, sp.Expr]] = field(default_factory=dict)
    null: str = ""
    tried: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    grown: bool = True
    imitated_by: str = ""
    hides: bool = False


@dataclass(frozen=True, kw_only=True)
class LinearSystem:
    """A linear filter behind the plant, x' = A x + B u, in closed form in the time loop.

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
    """One piece of hardware: parameters, terms, rates, and what it hands to others.

    Parameters
    ----------
    name : str
        Name in the wiring, e.g. ``"rotor"``.
    table : str
        Table of the mechanism file that holds its parameters, e.g. ``"gear"``.
    declarations : tuple of Declaration
        Parameters as the file knows them; several blocks may read one table.
    coordinates : mapping of Symbol to Expr
        Kernel parameters that are not simply a value of the file, as functions of the file's symbols.
    polar : tuple of PolarPair
    inputs : tuple of Symbol
        What the wiring must supply.
    terms : mapping of Symbol to Expr
        Named quantities; the kernel keeps their names.
    rates : mapping of state to Expr
        Time derivatives.
    initial : mapping of state to Expr
        States at the start of a record, those of the filter too; states of the filter that are not there are 0.
    starts : tuple of Declaration
        What a record may have of its own there: symbols of `initial` that are zero where it has not (`plant.start`).
    outputs : mapping of str to Expr
        What other blocks may be wired to.
    switch : Switch or None
    filter : LinearSystem or None
    swinging : mapping of state to str
        What swings where a resonance moves that state most; other states have the block's name, an empty word says
        that nothing does, as in a low-pass.
    scales : mapping of str to Expr
        What a data sheet names of it, as ``"holding torque"``: functions of the file's symbols.
    extensions : tuple of Extension
        What it may have beside, smooth at the null value.
    series : tuple of Series
        What it may have beside with other periods.
    rivals : tuple of Rival
        What may stand in place of something, without a null value; further starts of one are further entries.
    reference : str
        Where the equations stand.
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
    rivals: tuple[Rival, ...] = ()
    reference: str = "Kornienko2013"
