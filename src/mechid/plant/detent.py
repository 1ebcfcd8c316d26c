"""Detent torque of a stepper, one block per harmonic, and the harmonics that may be added."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

from sympy import Expr, Float, cos, pi, sin, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block, Extension, PolarPair, Series
from mechid.plant.drive_train import PER_STEP, alpha, p

DETENT = "stepper.detent"
WORDS = "detent torque with a period of {period_deg:.3g} deg of the rotor"
WHOLE_ORDER = 1e-9
"""Relative tolerance within which the periods per electrical period count as an integer."""
ORDERS = (1, 2, 4, 8, 12, 16)
"""Detent periods per electrical period that are tried if the file lacks them."""
RARER_ORDERS = (3, 5, 6, 7)
"""Detent periods that are tried if the others do not suffice."""
FURTHER_ORDERS = (10,)
"""Detent periods that are tested against a finished fit in addition."""
MOST_PERIODS = 400
"""Largest number of periods per turn for any other detent: two per full step of 1.8 deg."""


def detent(index: int, order: int | None, holding: str | None = "k_m*U/R") -> Block:
    """One harmonic of the detent torque: T = K sin(2 pi alpha / alpha_det + phi).

    Equation (4) of [Kornienko2013]_ with a phase, which the paper lacks; K in N m. The kernel's
    parameters are a = K cos(phi) and b = K sin(phi).

    Parameters
    ----------
    index : int
        Position in the file's list, from 0.
    order : int or None
        Periods per electrical period if that is an integer: the sine and cosine then follow
        from those of the windings by multiple angles. None: the period is used as given.
    holding : str or None
        The motor's holding torque in the file's symbols, if known.
    """
    k = index + 1
    a, b, K, phi, period = symbols(f"a_{k} b_{k} K_D{k} phi_{k} alpha_det{k}")
    # By order the kernel needs no further sine: multiple angles follow from the windings'.
    angle: Expr = order * p / 2 * alpha if order else 2 * pi / (period * pi / 180) * alpha
    return Block(
        name=f"detent_{k}",
        table=f"{DETENT}.{index}",
        declarations=(
            Declaration("period_deg", period.name, "deg", "detent period", lower=1e-6, structural=True),
            Declaration(
                key="amplitude",
                symbol=K.name,
                unit="N m",
                meaning="detent torque amplitude",
                lower=0.0,
                typical=(holding, 0.0, 0.2) if holding else None,
            ),
            Declaration("phase_deg", phi.name, "deg", "detent phase", default=0.0),
        ),
        coordinates={a: K * cos(phi * pi / 180), b: K * sin(phi * pi / 180)},
        polar=(PolarPair(amplitude="amplitude", phase="phase_deg", cosine=a, sine=b, cycles=360 / period),),
        inputs=(alpha,),
        outputs={f"T_D{k}": a * sin(angle) + b * cos(angle)},
    )


def detent_order(poles: float, period_deg: float) -> int | None:
    """Return a detent's periods per electrical period, or None if not an integer.

    An electrical period is 720/poles degrees of the rotor.

    Examples
    --------
    >>> detent_order(100, 1.8), detent_order(100, 3.6), detent_order(100, 2.5)
    (4, 2, None)
    """
    order = (720.0 / poles) / period_deg
    # A period typed with few digits is meant as the exact fraction of a period.
    whole = round(order) if math.isfinite(order) else 0
    return whole if whole >= 1 and abs(order - whole) <= WHOLE_ORDER * whole else None


def series(holding: Expr) -> Series:
    """Return the detents of any other integer number of periods per turn, with 2 % of the holding torque."""
    # A partial rather than a closure: a plant is pickled to reach other processes.
    return Series(per_step=PER_STEP, entry=partial(_extension, holding), most=MOST_PERIODS)


def _extension(holding: Expr, periods: int) -> Extension:
    return Extension(
        name=DETENT,
        words=WORDS,
        table=DETENT,
        structure={"period_deg": Float(360) / periods},
        widths={"amplitude": Float(0.02) * holding},
        grown=False,
    )


def extensions(orders: Sequence[int | None], holding: Expr) -> tuple[Extension, ...]:
    """Return the detents that may be added, with 2 % of the holding torque."""
    return tuple(
        Extension(
            name=DETENT,
            words=WORDS,
            table=DETENT,
            order=order,
            structure={"period_deg": 720 / (p * order)},
            widths={"amplitude": Float(0.02) * holding},
            grown=order in (*ORDERS, *RARER_ORDERS),
            rarer=order in RARER_ORDERS,
        )
        for order in (*ORDERS, *RARER_ORDERS, *FURTHER_ORDERS)
        if order not in orders
    )


def period_name(period_deg: float) -> str:
    """Return a period with three digits, or as many as identify its integer number of periods per turn.

    Examples
    --------
    >>> period_name(1.2), period_name(360.0 / 301.0), period_name(360.0 / 350.0)
    ('1.2deg', '1.196deg', '1.03deg')
    """
    periods = round(360.0 / period_deg)
    texts = (f"{period_deg:.{digits}g}" for digits in range(3, 7))
    told = next((text for text in texts if round(360.0 / float(text)) == periods), f"{period_deg:.3g}")
    return f"{told}deg"
