"""Test stand between the mechanism's base and the recorder: transducer, charge amplifier, anti-alias filter."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TypedDict

import numpy as np
from sympy import Expr, Float, Matrix, Symbol, pi, sin, sqrt, symbols

from mechid.arrays import ComplexArray, FloatArray
from mechid.parameter import Declaration, Role
from mechid.plant.block import Block, LinearSystem, Rival
from mechid.plant.housing import FAST, OVERDAMPED
from mechid.plant.start import OUTPUT_TORQUE
from mechid.plant.start import start as own_start

GAUTSCHI = "Gautschi, Piezoelectric Sensorics (Springer 2002)"
_parameter = partial(Declaration, source=GAUTSCHI)
BUTTERWORTH = "Butterworth, Experimental Wireless 7 (1930) 536-541"
MOST_ORDER = 8
LINE_FILTER = "line_filter"
"""Block and table of the filter in front of the sampling of torque lines."""
ALIAS_ORDERS = (4, 2)
"""Orders of low-passes that a recorder may have, the most likely first; delays that mimic them lead to both."""

_FILTERS = (
    Rival(
        name="charge_amplifier",
        words="high-pass of the charge amplifier",
        table="charge_amplifier",
        imitated_by="record.delay",
        free={"time_constant": (Float(1.0), Float(0.02), Float(100.0))},
        hides=True,
    ),
    *(
        Rival(
            name=f"anti_alias:{order}",
            words=f"low-pass of the recorder, order {order}",
            table="anti_alias",
            order=order,
            grown=order == ALIAS_ORDERS[0],
            imitated_by="record.delay",
            free={"frequency": (Float(12000.0), Float(2000.0), Float(30000.0))},
        )
        for order in ALIAS_ORDERS
    ),
)
"""Alternatives between the transducer and the recorder."""


def base_torque(*, loaded: bool = True) -> Block:
    """Torque of the mechanism on its base: y = -(T_residual + T_load), section 3.1 of [Kornienko2013]_; N m."""
    T_residual, T_load = symbols("T_residual_in T_load_in")
    return Block(
        name="transducer",
        table="",
        inputs=(T_residual, T_load) if loaded else (T_residual,),
        outputs={"T_base": -(T_residual + T_load) if loaded else -T_residual},
        rivals=_FILTERS,
    )


def transducer_gain(name: str = "sensor") -> Block:
    """Gain g of the transducer and its conditioning, negative for reversed polarity: y = g T."""
    T, g = symbols("T_in g_y")
    return Block(
        name=name, table="transducer", declarations=(_gain(),), inputs=(T,), outputs={"T": g * T}, reference=GAUTSCHI
    )


def transducer_resonance(name: str = "sensor") -> Block:
    """Transducer with its own resonance, y = g w^2/(s^2 + 2 zeta w s + w^2) T; w in rad/s."""
    w, declaration = (
        Symbol("omega_t"),
        _parameter(
            key="frequency",
            symbol="omega_t",
            unit="rad/s",
            meaning="resonance of the transducer with what stands on it",
            lower=0.0,
            hertz_below=FAST,
        ),
    )
    return _resonance(name, (declaration,), {}, w)


def transducer_adaptor(name: str = "sensor") -> Block:
    """Transducer whose resonance follows from its stiffness K_t and the inertia J_a on it: w = sqrt(K_t/J_a).

    J_a is the inertia of the adaptor and of the mechanism's fixed parts; only K_t/J_a is identifiable.
    """
    w, K_t, J_a = symbols("omega_t K_t J_a")
    declarations = (
        _parameter("stiffness", K_t.name, "N m/rad", "torsional stiffness of the transducer", lower=0.0),
        _parameter(
            "adaptor_inertia", J_a.name, "kg m2", "inertia on the transducer: adaptor and fixed parts", lower=0.0
        ),
    )
    return _resonance(name, declarations, {w: sqrt(K_t / J_a)}, w)


def _resonance(name: str, own: tuple[Declaration, ...], coordinates: Mapping[Symbol, Expr], w: Symbol) -> Block:
    T, g, zeta, x, v = symbols("T_in g_y zeta_t x_t v_t")
    meaning = "damping ratio of the transducer's resonance"
    damping = _parameter("damping", zeta.name, "1", meaning, lower=0.0, percent_above=OVERDAMPED)
    return Block(
        name=name,
        table="transducer",
        declarations=(_gain(), *own, damping),
        coordinates=coordinates,
        inputs=(T,),
        outputs={"T": g * x},
        **_from_start({"transducer": x, "transducer_rate": v}, "torque on the transducer"),
        filter=LinearSystem(
            states=(x, v), inputs=(T,), A=w * Matrix([[0, 1], [-1, -2 * zeta]]), B=w * Matrix([[0], [1]])
        ),
        reference=GAUTSCHI,
    )


def charge_amplifier(name: str = "charge_amplifier") -> Block:
    """High-pass of a charge amplifier: y = tau s/(tau s + 1) T, by x' = (T - x)/tau, y = T - x; tau in s."""
    T, tau, x = symbols("T_in tau_q x_q")
    constant = _parameter("time_constant", tau.name, "s", "time constant of the charge amplifier", lower=0.0)
    return Block(
        name=name,
        table="charge_amplifier",
        declarations=(constant,),
        inputs=(T,),
        outputs={"T": T - x},
        **_from_start({"charge_amplifier": x}, "torque that the charge amplifier has taken for its zero"),
        filter=LinearSystem(states=(x,), inputs=(T,), A=Matrix([[-1 / tau]]), B=Matrix([[1 / tau]])),
        reference=GAUTSCHI,
    )


def anti_alias(order: int, name: str = "anti_alias", *, cut_off: str = "omega_c", state: str = "x_a") -> Block:
    """Butterworth low-pass of a given order with cut-off omega_c (rad/s), as a cascade of first and second order.

    The poles of the second-order sections have the damping ratios sin((2 k - 1) pi/(2 n)). A second low-pass in one
    plant needs another name, which is also that of its table, and other symbols.
    """
    T, w = symbols(f"T_in {cut_off}")
    x = symbols(f"{state}1:{order + 1}")
    A, B = Matrix.zeros(order, order), Matrix.zeros(order, 1)
    source: Symbol | None = None
    for k in range(1, order // 2 + 1):
        first, second = 2 * k - 2, 2 * k - 1
        # Evaluated to double precision: the same numbers as in `anti_alias_response`, and no radicals in the kernel.
        zeta = sin(pi * (2 * k - 1) / (2 * order)).evalf(17)
        A[first, second], A[second, first], A[second, second] = w, -w, -2 * zeta * w
        _feed(A, B, second, source, x, w)
        source = x[first]
    # An odd order has one real pole.
    if order % 2:
        A[order - 1, order - 1] = -w
        _feed(A, B, order - 1, source, x, w)
        source = x[order - 1]
    declarations = (
        Declaration(
            key="order",
            symbol=f"n_{state[-1]}",
            unit="1",
            meaning="order of the Butterworth filter",
            lower=1.0,
            upper=float(MOST_ORDER),
            structural=True,
            default=4.0,
            source=BUTTERWORTH,
        ),
        Declaration(
            key="frequency",
            symbol=w.name,
            unit="rad/s",
            meaning="cut-off of the anti-alias filter",
            lower=0.0,
            source=BUTTERWORTH,
            hertz_below=FAST,
            role=Role.CUT_OFF,
        ),
    )
    return Block(
        name=name,
        table=name,
        declarations=declarations,
        inputs=(T,),
        outputs={"T": source if source is not None else T},
        **_from_start({f"{name}_{k}": s for k, s in enumerate(x, 1)}, "torque within the low-pass"),
        filter=LinearSystem(states=tuple(x), inputs=(T,), A=A, B=B),
        swinging=dict.fromkeys(x, ""),
        reference=BUTTERWORTH,
    )


def line_filter(order: int) -> Block:
    """Low-pass in front of the sampling of torque lines; not part of the test stand."""
    return anti_alias(order, LINE_FILTER, cut_off="omega_l", state="x_l")


def anti_alias_response(order: int, cut_off: float, frequency_hz: FloatArray) -> ComplexArray:
    """Return the response of `anti_alias` for an order and a cut-off in rad/s, (n,) complex."""
    s = 2j * np.pi * np.asarray(frequency_hz, dtype=np.float64) / cut_off
    out = np.ones_like(s) if order % 2 == 0 else 1.0 / (s + 1.0)
    for k in range(1, order // 2 + 1):
        out = out / (s**2 + 2.0 * np.sin(np.pi * (2 * k - 1) / (2 * order)) * s + 1.0)
    return np.asarray(out, dtype=np.complex128)


def _feed(A: Matrix, B: Matrix, row: int, source: Symbol | None, x: tuple[Symbol, ...], w: Symbol) -> None:
    """Connect a section to the one before it, the first to the filter's input."""
    if source is None:
        B[row, 0] = w
    else:
        A[row, x.index(source)] += w


def _from_start(states: Mapping[str, Symbol], meaning: str) -> _Start:
    """Return the entries of a block for its filter's initial states, each a start value of a record."""
    own = {key: Symbol(f"{state.name}_start") for key, state in states.items()}
    return {
        "initial": {state: own[key] for key, state in states.items()},
        "starts": tuple(
            own_start(key, symbol, "N m", f"{meaning} at the start", OUTPUT_TORQUE) for key, symbol in own.items()
        ),
    }


class _Start(TypedDict):
    initial: dict[Symbol, Expr]
    starts: tuple[Declaration, ...]


def _gain() -> Declaration:
    return _parameter(
        key="gain",
        symbol="g_y",
        unit="1",
        meaning="gain of the transducer, negative for the other polarity",
        default=1.0,
        role=Role.TRANSDUCER_GAIN,
    )


TRANSDUCERS: Mapping[str, Callable[[], Block]] = {
    "gain": transducer_gain,
    "resonance": transducer_resonance,
    "adaptor": transducer_adaptor,
}
"""Transducer models by their names in mechanism.toml."""
