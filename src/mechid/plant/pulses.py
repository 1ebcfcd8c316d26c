"""Pulsed drive: phases fed for a time after each step, then held at a share or open but for clamping diodes.

An open coil keeps its current until the voltage of its clamp has taken it away; without current it shows its back-EMF,
and conducts again where that exceeds the clamp. Instants of all changes are switches of the plant (`open_coil`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from sympy import Expr, Float, Symbol, symbols

from mechid.errors import InputFileError
from mechid.parameter import Declaration
from mechid.plant import current_limit, microstep_table, saliency, supply
from mechid.plant.block import Block, Guard, Rival, Switch
from mechid.plant.layout import Layout
from mechid.plant.phases import HARMONIC, STAR
from mechid.plant.stepper import current_fed, windings

TABLE, OPTION = "stepper.pulses", "between"
ON, HOLD = f"{TABLE}.on_s", f"{TABLE}.hold"
OPEN, HELD, BOTH_WAYS = "open", "held", "open_both_ways"
LAWS = (OPEN, HELD, BOTH_WAYS)
"""States of the phases between pulses, the default first."""
ACARNLEY = "Acarnley, Stepping Motors: a Guide to Theory and Practice, 4th ed. (2002), chapter 2: freewheeling diodes"
FED_MODE = "fed"
"""Mode of a coil's switch in which the drive feeds it."""
FED = 1e-6
"""Share of the peak voltage above which a phase counts as fed: far below a microstep, above rounding."""
BEYOND = Float(1 + 1e-9)
"""Back-EMF over the clamp at which a coil conducts: just above 1, so that rounding cannot end its current at once."""
VOLTAGE_ALONE = ("stepper.imbalance", saliency.TABLE, supply.TABLE, current_limit.TABLE, microstep_table.TABLE)
"""Tables whose equations do not know of an open phase."""
R, L, V_clamp, V_diode = symbols("R L V_clamp V_diode")
_parameter = partial(Declaration, source=ACARNLEY)
_ON = _parameter(ON, "t_on", "s", "duration of a pulse after each step", lower=1e-6, structural=True)
_HOLD = _parameter(HOLD, "h_hold", "1", "share that stays between pulses", lower=0.0, upper=1.0, structural=True)
_CLAMP = (
    _parameter(
        f"{TABLE}.clamp_V",
        V_clamp.name,
        "V",
        "voltage of the clamp against which an open phase conducts",
        lower=0.01,
        supply_power=1,
    ),
    _parameter(
        f"{TABLE}.diode_drop_V",
        V_diode.name,
        "V",
        "drop of the diodes in series with the clamp",
        lower=0.0,
        default=0.0,
        supply_power=1,
    ),
)
DECLARATIONS: Mapping[str, tuple[Declaration, ...]] = {
    OPEN: (_ON, *_CLAMP),
    BOTH_WAYS: (_ON, *_CLAMP),
    HELD: (_ON, _HOLD),
}
_OPEN_INSTEAD = Rival(
    name=f"{TABLE}.{OPEN}",
    words="the phases are open between pulses, and their current flows against clamps",
    table=TABLE,
    law=OPEN,
    free={"clamp_V": (Float(2.0), Float(0.3), Float(60.0))},
)


@dataclass(frozen=True)
class Coil:
    """A coil of a pulsed motor.

    Attributes
    ----------
    name : str
        ``"A"`` to ``"D"``: at 0, 90, 180 and 270 deg.
    axis : str
        ``"A"`` or ``"B"``: the phase whose voltage and back-EMF it has, with a sign.
    sign : {1, -1}
    half : bool
        Whether it is half of a pole's winding, which the driver feeds in its own direction only.
    """

    name: str
    axis: str
    sign: int = 1
    half: bool = False


COILS: Mapping[int, tuple[Coil, ...]] = {
    2: (Coil("A", "A"), Coil("B", "B")),
    4: tuple(
        Coil(name, axis, sign, half=True) for name, axis, sign in zip("ABCD", "ABAB", (1, 1, -1, -1), strict=True)
    ),
}
"""Coils of a motor by its number of phases."""


def law_of(layout: Layout) -> str:
    """Return the state of the phases between pulses, empty where there are none."""
    return layout.law(TABLE, LAWS, OPTION) if TABLE in layout.tables else ""


def check_pulses(layout: Layout, drive: str) -> None:
    """Refuse pulses on a drive that cannot have them, and tables that do not know of open phases.

    Raises
    ------
    InputFileError
        The drive follows measured channels; or phases are open and the motor has three, a current drive or such tables.
    """
    law = law_of(layout)
    if law and drive not in ("voltage", "current"):
        raise InputFileError(f'{TABLE}: drive = "{drive}" has the pulses in its channels; delete the table')
    if law in (OPEN, BOTH_WAYS):
        _check_open(layout, drive, law)


def _check_open(layout: Layout, drive: str, law: str) -> None:
    remedy = f'write {OPTION} = "{HELD}"'
    if drive != "voltage":
        raise InputFileError(f'{TABLE}: open phases need drive = "voltage", found "{drive}"; {remedy}')
    if layout.phases == STAR:
        raise InputFileError(f"{TABLE}: open phases are of two or four, the motor has {STAR}; {remedy}")
    if law == BOTH_WAYS and layout.phases == 2:
        raise InputFileError(f'{TABLE}: clamps of a bridge conduct both ways anyway; write {OPTION} = "{OPEN}"')
    there = {*layout.tables, *layout.orders}
    if wrong := next((name for name in VOLTAGE_ALONE if name in there), None):
        raise InputFileError(f"{wrong}: does not know of phases that are open between pulses; delete one of the tables")


def declare_pulses(drive: Block, layout: Layout, source: str) -> Block:
    """Return a drive that declares the values of its pulses; without open phases its equations stay as they are."""
    law = law_of(layout)
    declared = replace(drive, declarations=(*drive.declarations, *DECLARATIONS[law]))
    if law != HELD:
        return replace(declared, extensions=())
    try:
        _check_open(layout, source, OPEN)
    except InputFileError:
        return declared
    return replace(declared, rivals=(*declared.rivals, _OPEN_INSTEAD))


def open_coil(coil: Coil, *, both_ways: bool) -> Block:
    """Return a coil that a driver feeds in pulses: L di/dt = u - R i - emf while it conducts, else i = 0.

    While it is fed u is the drive's voltage. Open, a current i > 0 flows against the clamp, u = -(V_clamp + V_diode),
    and i < 0 against the other, until it is zero; the coil then shows its emf, and conducts again where that exceeds
    the clamp. Half of a unipolar winding conducts in its own direction alone, fed or open, unless its clamp conducts
    `both_ways`. Acarnley (2002), chapter 2.
    """
    name, i = coil.name, Symbol(f"i_coil_{coil.name}")
    u, duty, emf = (coil.sign * Symbol(f"{key}_{coil.axis}_in") for key in ("u", "duty", "emf"))
    conducts, fed, side = (Symbol(f"{key}_{name}") for key in ("conducts", "fed", "side"))
    clamp, is_fed = V_clamp + V_diode, duty - Float(FED) if coil.half else duty**2 - Float(FED) ** 2
    one_way = coil.half and not both_ways
    voltage = fed * u + side * clamp
    modes = {
        FED_MODE: (1.0, 1.0, 0.0),
        "positive": (1.0, 0.0, -1.0),
        "negative": (1.0, 0.0, 1.0),
        "blocked": (0.0, 0.0, 0.0),
        "open": (0.0, 0.0, 0.0),
    }
    for unused in ["negative"] if one_way else ["blocked"]:
        del modes[unused]
    return Block(
        name=f"coil_{name}",
        table="stepper",
        inputs=tuple(Symbol(f"{key}_{coil.axis}_in") for key in ("u", "duty", "emf")),
        rates={i: conducts * (voltage - R * i - emf) / L},
        initial={i: Float(0)},
        outputs={f"i_{name}": i, f"v_{name}": conducts * voltage + (1 - conducts) * emf},
        switch=Switch(
            name=f"coil {name}",
            modes={mode: dict(zip((conducts, fed, side), values, strict=True)) for mode, values in modes.items()},
            guards=_guards(i, u, emf, clamp, is_fed, one_way=one_way),
            entry=((is_fed, FED_MODE), (i, "positive"), *([] if one_way else [(-i, "negative")])),
            otherwise="open",
            ideal={conducts: 0.0, fed: 0.0, side: 0.0},
        ),
        reference=ACARNLEY,
    )


def _guards(i: Symbol, u: Expr, emf: Expr, clamp: Expr, is_fed: Expr, *, one_way: bool) -> dict[str, tuple[Guard, ...]]:
    """Return the guards of a coil's modes; a current that ends is zero."""
    begins = Guard(margin=-is_fed, target=FED_MODE)

    def ends(margin: Expr, target: str = "open") -> Guard:
        return Guard(margin=margin, target=target, resets={i: 0.0})

    found = {
        FED_MODE: (Guard(margin=is_fed), *([ends(i, "blocked")] if one_way else [])),
        "positive": (begins, ends(i)),
        "open": (begins, Guard(margin=emf + BEYOND * clamp, target="positive")),
    }
    if one_way:
        return {**found, "blocked": (Guard(margin=is_fed), Guard(margin=BEYOND * emf - u, target=FED_MODE))}
    found["open"] += (Guard(margin=BEYOND * clamp - emf, target="negative"),)
    return {**found, "negative": (begins, ends(-i))}


def pulsed_motor(
    drive: Block, harmonics: Sequence[int], phases: int, law: str
) -> tuple[list[Block], dict[str, str], dict[str, str]]:
    """Return drive, coils and their torque, their wiring, and the outputs of currents and voltages of the phases."""
    usual = windings(harmonics=harmonics, commanded=False, phases=phases)
    torque = replace(
        current_fed(harmonics=harmonics, limited=True, commanded=False, phases=phases),
        declarations=usual.declarations,
        extensions=tuple(e for e in usual.extensions if e.table == HARMONIC),
    )
    coils = COILS[phases]
    blocks = [drive, torque, *(open_coil(coil, both_ways=law == BOTH_WAYS) for coil in coils)]
    of_axes = {axis: f"coil_{axis}.i_{axis}" for axis in "AB"}
    wiring: dict[str, str] = {}
    if phases == 4:
        blocks.append(_poles())
        wiring |= {f"poles.i_{coil.name}": f"coil_{coil.name}.i_{coil.name}" for coil in coils}
        of_axes = {axis: f"poles.i_axis_{axis}" for axis in "AB"}
    wiring |= {f"windings.i_{axis}": source for axis, source in of_axes.items()}
    measured = {
        f"{quantity}_phase_{coil.name.lower()}": f"coil_{coil.name}.{letter}_{coil.name}"
        for quantity, letter in (("current", "i"), ("voltage", "v"))
        for coil in coils
    }
    return blocks, wiring, measured


def _poles() -> Block:
    """Return the current of each axis of a unipolar motor: that of one half of a winding less that of the other."""
    i = {name: Symbol(f"i_{name}_in") for name in "ABCD"}
    return Block(
        name="poles",
        table="stepper",
        inputs=tuple(i.values()),
        outputs={"i_axis_A": i["A"] - i["C"], "i_axis_B": i["B"] - i["D"]},
        reference=ACARNLEY,
    )
