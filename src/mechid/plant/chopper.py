"""Chopper of a current drive: the switched loop whose average `current_limit` is."""

from __future__ import annotations

from functools import partial

from sympy import Expr, Float, Integer, Symbol, sign

from mechid.errors import InputFileError
from mechid.parameter import Declaration
from mechid.plant import current_limit
from mechid.plant.block import Agreement, Block, Guard, NamedOrder, Switch
from mechid.plant.current_limit import ACARNLEY, BAND, I_peak, L, R, U_s, current_start
from mechid.plant.layout import Layout

TABLE, OPTION = "stepper.chop", "decay"
SLOW, FAST, MIXED = "slow", "fast", "mixed"
DECAYS = (SLOW, FAST, MIXED)
"""Ways in which the current falls while the bridge is off, the default first."""
f_c, h_c, t_fast = Symbol("f_chop"), Symbol("h_chop"), Symbol("t_fast_chop")
NEVER = Float(1e-12)
"""Margin in A^2 that a guard keeps where there is no hysteresis; it moves a threshold by NEVER / hysteresis."""
_parameter = partial(Declaration, source=ACARNLEY, lower=0.0, structural=True)
_OF_ALL = (
    _parameter(f"{TABLE}.frequency_hz", f_c.name, "Hz", "clock that switches on; none where left out", default=0.0),
    _parameter(
        f"{TABLE}.hysteresis_A",
        h_c.name,
        "A",
        "width of the band around the commanded current; 0 with a clock alone",
        default=0.0,
    ),
)
_FAST_S = _parameter(
    f"{TABLE}.fast_s", t_fast.name, "s", "duration of fast decay after a phase is switched off", lower=1e-9
)


def check_chopper(layout: Layout) -> str:
    """Return the decay of a drive's chopper, empty where there is none.

    Raises
    ------
    InputFileError
        There is no `[stepper.current_limit]`, which has the supply and the coil.
    """
    if TABLE not in layout.tables:
        return ""
    decay = layout.law(TABLE, DECAYS, OPTION)
    if current_limit.TABLE not in layout.tables:
        raise InputFileError(f"{TABLE}: needs [{current_limit.TABLE}], with supply and coil; add it")
    return decay


CONTROL = Agreement(
    name=TABLE,
    value=1 + sign(f_c + h_c),
    wanted=Integer(2),
    within=0.0,
    words="nothing switches a phase on again; give frequency_hz or hysteresis_A",
)

CLOCK = NamedOrder("chopper", "clock of the chopper, or where sampling folds it back", f_c, per_second=True)


def chopped_loop(phase: str, decay: str) -> Block:
    """Return a phase's switched loop: L di/dt = u - R i - emf, with the voltage of a bridge.

    With s the sign of the commanded current i_ref, u = s U_s while the phase is on, until s i reaches s i_ref + h/2;
    then u = 0 (slow decay) or -s U_s (fast), or fast for `fast_s` and slow after that (mixed), until the next tick of
    the clock, or until s i has fallen to s i_ref - h/2. Clocks of both phases are half a period apart. Acarnley (2002).

    Parameters
    ----------
    phase : str
        ``"A"`` or ``"B"``; the first declares the parameters of both.
    decay : str
        One of `DECAYS`.
    """
    i, i_ref, emf = Symbol(f"i_coil_{phase}"), Symbol(f"i_ref_{phase}_in"), Symbol(f"emf_{phase}_in")
    clock, timer, own = Symbol(f"clock_{phase}"), Symbol(f"decayed_{phase}"), Symbol(f"i_{phase}_start")
    bridge, timed = Symbol(f"bridge_{phase}"), Symbol(f"timed_{phase}")
    first = 0.0 if phase == "A" else 0.5
    mixed = decay == MIXED
    modes: dict[str, dict[Symbol, float]] = {}
    guards: dict[str, tuple[Guard, ...]] = {}
    for way, s in (("forward", 1.0), ("backward", -1.0)):
        on, again, off, falling = (f"{way}, {state}" for state in ("on", "on again", "off", "fast"))
        tripped, missing = falling if mixed else off, s * (i_ref - i)
        turned = Guard(margin=s * i_ref + Float(BAND) * I_peak)
        modes |= {on: {bridge: s, timed: 0.0}, again: {bridge: s, timed: 0.0}}
        modes[off] = {bridge: -s if decay == FAST else 0.0, timed: 0.0}
        # A tick while the phase is on only restarts the clock, which takes a change of mode.
        for mode, other in ((on, again), (again, on)):
            guards[mode] = (Guard(margin=missing + h_c / 2, target=tripped), turned, _tick(clock, timer, other, mixed))
        below = Guard(margin=h_c * (h_c / 2 - missing) + NEVER, target=on)
        guards[off] = (_tick(clock, timer, on, mixed), below, turned)
        if mixed:
            modes[falling] = {bridge: -s, timed: 1.0}
            ended = Guard(margin=t_fast - timer, target=off, resets={timer: 0.0})
            guards[falling] = (ended, _tick(clock, timer, on, mixed), below, turned)
    return Block(
        name=f"loop_{phase}",
        table=current_limit.TABLE,
        declarations=(*current_limit.DECLARATIONS, *_OF_ALL, *([_FAST_S] if mixed else [])) if phase == "A" else (),
        inputs=(i_ref, emf),
        rates={i: (bridge * U_s - R * i - emf) / L, clock: f_c, **({timer: timed} if mixed else {})},
        initial={i: i_ref + own, clock: Float(first), **({timer: Float(0)} if mixed else {})},
        starts=(current_start(phase, own),),
        outputs={f"i_{phase}": i, f"v_{phase}": bridge * U_s},
        switch=Switch(
            name=f"chopper {phase}",
            modes=modes,
            guards=guards,
            entry=((-i_ref, "backward, off"),),
            otherwise="forward, off",
            ideal={bridge: 0.0, timed: 0.0},
        ),
        agreements=(CONTROL,) if phase == "A" else (),
        named_orders=(CLOCK,) if phase == "A" else (),
        # Clock and timer run, and do not swing.
        swinging={clock: "", **({timer: ""} if mixed else {})},
        reference=ACARNLEY,
    )


def _tick(clock: Expr, timer: Symbol, target: str, mixed: bool) -> Guard:
    """Return the guard of a clock's tick, which restarts it, and the timer of fast decay."""
    return Guard(margin=1 - clock, target=target, resets={clock: 0.0, **({timer: 0.0} if mixed else {})})
