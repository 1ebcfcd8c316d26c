"""Current drive with limited voltage: its loops follow the commanded currents as fast as the supply permits."""

from __future__ import annotations

from functools import partial

from sympy import Float, Symbol, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block, Guard, Rival, Switch
from mechid.plant.start import start as own_start

TABLE = "stepper.current_limit"
ACARNLEY = "Acarnley, Stepping Motors: a Guide to Theory and Practice, 4th ed. (2002), chapter 5: chopper drive"
_parameter = partial(Declaration, source=ACARNLEY)
BAND = 1e-6
"""Tolerance within which a loop follows, relative to the peak current: far below a microstep, far above rounding."""
k_v, R, L, U_s, I_peak = symbols("k_v R_loop L_loop U_loop I_peak")
DECLARATIONS = (
    _parameter("voltage", U_s.name, "V", "supply voltage, the most that a phase is given", lower=0.0),
    _parameter("resistance", R.name, "ohm", "resistance of a coil and its switches", lower=0.0, supply_power=-1),
    _parameter("inductance", L.name, "H", "inductance of a coil", lower=0.0, supply_power=-1),
    _parameter(
        "back_emf_constant", k_v.name, "V s/rad", "back-EMF constant", lower=0.0, tied_to="stepper.torque_constant"
    ),
)


def loop(phase: str) -> Block:
    """Return a phase's loop: i = i_ref while the supply suffices, else L di/dt = +-U_s - R i - emf until it does.

    Three modes. i_ref in A is the current of the ideal drive, held from step to step; emf in V is the coil's. Within
    the supply the chopper holds the current, so that di/dt = 0; a step of the command, or an emf that would require
    more than U_s, ends that. The chopper's ripple is not modelled. Acarnley (2002).

    Parameters
    ----------
    phase : str
        ``"A"`` or ``"B"``; the first declares the parameters of both.
    """
    i, i_ref, emf = Symbol(f"i_coil_{phase}"), Symbol(f"i_ref_{phase}_in"), Symbol(f"emf_{phase}_in")
    forced, side, own = Symbol(f"forced_{phase}"), Symbol(f"side_{phase}"), Symbol(f"i_{phase}_start")
    behind, band, wanted = i_ref - i, Float(BAND) * I_peak, R * i + emf
    switch = Switch(
        name=f"current {phase}",
        modes={
            "following": {forced: 0.0, side: 0.0},
            "rising": {forced: 1.0, side: 1.0},
            "falling": {forced: 1.0, side: -1.0},
        },
        guards={
            "following": (
                # A band instead of zero: rounding of a followed current must not end the mode.
                Guard(margin=band - behind, target="rising"),
                Guard(margin=band + behind, target="falling"),
                Guard(margin=U_s - wanted, target="rising"),
                Guard(margin=U_s + wanted, target="falling"),
            ),
            "rising": (Guard(margin=behind),),
            "falling": (Guard(margin=-behind),),
        },
        entry=((behind - band, "rising"), (-behind - band, "falling")),
        otherwise="following",
        ideal={forced: 0.0, side: 0.0},
    )
    return Block(
        name=f"loop_{phase}",
        table=TABLE,
        declarations=DECLARATIONS if phase == "A" else (),
        inputs=(i_ref, emf),
        # `forced` is 0 while the chopper holds the current.
        rates={i: forced * (side * U_s - wanted) / L},
        initial={i: i_ref + own},
        starts=(current_start(phase, own),),
        outputs={f"i_{phase}": i},
        switch=switch,
        reference=ACARNLEY,
    )


def current_start(phase: str, own: Symbol) -> Declaration:
    """Return the start value of a phase's current."""
    words = f"current of phase {phase} at the start, off where it settles"
    return own_start(f"current_{phase.lower()}", own, "A", words, "T_hold/k_m")


RIVAL = Rival(
    name=TABLE,
    words="the current drive runs out of voltage",
    table=TABLE,
    grown=False,
    free={
        "voltage": (Float(24.0), Float(3.0), Float(200.0)),
        "resistance": (Float(5.0), Float(0.2), Float(100.0)),
        "inductance": (Float(0.01), Float(2e-4), Float(0.3)),
    },
)
