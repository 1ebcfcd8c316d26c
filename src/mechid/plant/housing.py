"""Flexible housing between the rotor's reaction and the torque transducer (section 5.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sympy import Expr, Float, Integer, Matrix, Symbol, diag, symbols

from mechid.errors import InputFileError, did_you_mean
from mechid.parameter import Declaration
from mechid.plant.block import Block, LinearSystem, Rival
from mechid.plant.start import start as own_start

FORMS = ("paper", "unit_dc")
EWINS = "Ewins, Modal Testing, 2nd ed. (2000)"
TRIED = tuple(round(700.0 * 2.0 ** (k / 4), 1) for k in range(21))
"""Frequencies in rad/s at which a second mode is tried, a quarter of an octave apart: 110 Hz to 3.6 kHz."""
FAST = 1500.0
"""A resonance of housing or test stand below this, in rad/s, is below 240 Hz: it may have been meant in hertz."""
OVERDAMPED = 1.0
"""Damping ratio from which nothing resonates: the number may have been meant in percent."""


def housing(form: str, *, second: bool = False) -> Block:
    """One resonance on the residual torque: z_ddot + 2 zeta w0 z_dot + w0^2 z = K_res w0^2 T_res.

    Section 5.3 of [Kornienko2013]_, whose numerator is lost; z in N m. The second state is z_dot/w0,
    so that both have the same magnitude. Form ``"paper"``: the transducer measures z (its static gain K_res
    violates the momentum balance at low frequency). Form ``"unit_dc"``: it measures
    T_res (1 + K s^2/(s^2 + 2 zeta w0 s + w0^2)), of static gain 1. With a second mode it measures the sum of both,
    as for a structure described by its modes (Ewins): z + z_2, or T_res (1 + K s^2/(...) + K_2 s^2/(...)).

    Parameters
    ----------
    form : str
        One of `FORMS`.
    second : bool
        Whether there is a second mode.

    Raises
    ------
    InputFileError
        `form` is unknown.
    """
    if form not in FORMS:
        hint = did_you_mean(form, FORMS) or f"; known: {', '.join(FORMS)}"
        raise InputFileError(f'housing.form: unknown form "{form}"{hint}')
    T_res = Symbol("T_res_in")
    modes = (FIRST, SECOND) if second else (FIRST,)
    seen: Expr = sum((m.z for m in modes), Integer(0))
    # K s^2/(s^2 + 2 zeta w0 s + w0^2) is K less a low-pass, so the states need no derivative of the torque.
    if form != "paper":
        below = sum((m.gain * (m.z + 2 * m.damping * m.v) for m in modes), Integer(0))
        seen = (1 + sum((m.gain for m in modes), Integer(0))) * T_res - below
    return Block(
        name="housing",
        table="housing",
        declarations=tuple(d for m in modes for d in m.declarations),
        inputs=(T_res,),
        outputs={"T_residual": seen},
        initial={state: own for m in modes for state, own in m.start_symbols.items()},
        starts=tuple(d for m in modes for d in m.starts),
        filter=LinearSystem(
            states=tuple(state for m in modes for state in (m.z, m.v)),
            inputs=(T_res,),
            A=diag(*(m.frequency * Matrix([[0, 1], [-1, -2 * m.damping]]) for m in modes)),
            # In the paper's form the gain scales the filter's input, in the other its output.
            B=Matrix.vstack(*(m.frequency * Matrix([[0], [m.gain if form == "paper" else 1]]) for m in modes)),
        ),
        swinging=dict.fromkeys((SECOND.z, SECOND.v), "housing, second mode") if second else {},
        rivals=() if second else (_second_mode(),),
    )


@dataclass(frozen=True, kw_only=True)
class _Mode:
    """One mode: its symbols, its table, and the names of its states at the start."""

    table: str
    z: Symbol
    v: Symbol
    gain: Symbol
    frequency: Symbol
    damping: Symbol
    key: str
    word: str
    whose: str
    least_gain: float
    source: str

    @property
    def declarations(self) -> tuple[Declaration, ...]:
        return (
            Declaration(
                key=f"{self.table}.gain",
                symbol=self.gain.name,
                unit="1",
                meaning=f"{self.word} resonance factor",
                lower=self.least_gain,
                source=self.source,
            ),
            Declaration(
                key=f"{self.table}.frequency",
                symbol=self.frequency.name,
                unit="rad/s",
                meaning=f"{self.word} resonance frequency",
                lower=0.0,
                hertz_below=FAST,
                source=self.source,
            ),
            Declaration(
                key=f"{self.table}.damping",
                symbol=self.damping.name,
                unit="1",
                meaning=f"{self.word} damping ratio",
                lower=0.0,
                percent_above=OVERDAMPED,
                source=self.source,
            ),
        )

    @property
    def start_symbols(self) -> dict[Symbol, Symbol]:
        """Symbols of the start values of its states."""
        return {state: Symbol(f"{state.name}_start") for state in (self.z, self.v)}

    @property
    def starts(self) -> tuple[Declaration, ...]:
        size, (z, v) = f"T_hold*{self.gain}", self.start_symbols.values()
        return (
            own_start(self.key, z, "N m", f"torque of the {self.whose} at the start", size),
            own_start(f"{self.key}_rate", v, "N m", "its rate at the start over its frequency", size),
        )


FIRST = _Mode(
    table="housing",
    z=Symbol("z"),
    v=Symbol("v_z"),
    gain=Symbol("K_res"),
    frequency=Symbol("omega_0"),
    damping=Symbol("zeta"),
    key="housing",
    word="housing",
    whose="housing's mode",
    least_gain=0.0,
    source="Kornienko2013",
)
SECOND = _Mode(
    table="housing.second_mode",
    z=Symbol("z_res2"),
    v=Symbol("v_res2"),
    gain=Symbol("K_res2"),
    frequency=Symbol("omega_res2"),
    damping=Symbol("zeta_res2"),
    key="housing_second_mode",
    word="second housing",
    whose="housing's second mode",
    least_gain=-math.inf,
    source=EWINS,
)


def _second_mode() -> Rival:
    """Return a second mode that may be added; it vanishes at zero gain."""
    return Rival(
        name=SECOND.table,
        words="second resonance of the housing",
        table=SECOND.table,
        null="gain",
        grown=False,
        free={
            "gain": (Float(0.3), Float(-20.0), Float(20.0)),
            "damping": (Float(0.1), Float(0.003), Float(0.5)),
            "frequency": (Float(3000.0), Float(300.0), Float(30000.0)),
        },
        tried={"frequency": TRIED},
    )


def rigid_housing() -> Block:
    """No resonance: the transducer measures the residual torque itself; N m."""
    (T_res,) = symbols("T_res_in,")
    resonance = Rival(
        name="housing",
        words="resonance of the housing",
        table="housing",
        law=FORMS[0],
        free={
            "gain": (Float(2.0), Float(0.05), Float(20.0)),
            "damping": (Float(0.05), Float(0.005), Float(0.5)),
            "frequency": (Float(5000.0), Float(500.0), Float(20000.0)),
        },
    )
    return Block(name="housing", table="housing", inputs=(T_res,), outputs={"T_residual": T_res}, rivals=(resonance,))
