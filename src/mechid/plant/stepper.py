"""Two-phase stepper motor (E2P): windings, detent torque, and their sum."""

from __future__ import annotations

from sympy import Expr, Symbol, cos, pi, sin, symbols

from mechid.parameter import Declaration
from mechid.plant.block import Block, PolarPair

p, R, L, k_m, k_v, shift_B = symbols("p R L k_m k_v shift_B")
alpha, omega = symbols("alpha omega")


def windings() -> Block:
    """Two windings: L di/dt = u - R i - k_v omega sin(p/2 alpha + shift), T = k_m i sin(p/2 alpha + shift).

    Equations (1) to (3) of [Kornienko2013]_; i in A, u in V, alpha in rad, omega in rad/s, T in N m.
    Phase A has no shift, phase B `phase_shift_deg` (90 deg where nothing is given).
    """
    phi_shift = Symbol("phi_shift")
    phases = {"A": sin(p / 2 * alpha), "B": sin(p / 2 * alpha + shift_B)}
    i = {x: Symbol(f"i_{x}") for x in phases}
    u = {x: Symbol(f"u_{x}_in") for x in phases}
    return Block(
        name="windings",
        table="stepper",
        declarations=_WINDING_DECLARATIONS,
        coordinates={shift_B: phi_shift * pi / 180},
        inputs=(*u.values(), alpha, omega),
        rates={i[x]: (u[x] - R * i[x] - k_v * omega * coupling) / L for x, coupling in phases.items()},
        initial={i[x]: u[x] / R for x in phases},
        outputs={"T": sum(k_m * i[x] * coupling for x, coupling in phases.items())},
    )


_WINDING_DECLARATIONS = (
    Declaration(key="poles", symbol="p", unit="1", meaning="number of poles", lower=2.0,
                structural=True),
    Declaration(key="coil_resistance", symbol="R", unit="ohm", meaning="coil resistance", lower=0.0,
                spread=1.25),
    Declaration(key="coil_inductance", symbol="L", unit="H", meaning="coil inductance", lower=0.0),
    Declaration(key="torque_constant", symbol="k_m", unit="N m/A", meaning="torque constant", lower=0.0),
    Declaration(
        key="back_emf_constant", symbol="k_v", unit="V s/rad", meaning="back-EMF constant", lower=0.0
    ),
    Declaration(
        key="phase_shift_deg", symbol="phi_shift", unit="deg", default=90.0,
        meaning="electrical angle from phase A to phase B", lower=-360.0, upper=360.0,
    ),
)  # fmt: skip


def detent(index: int, order: int | None) -> Block:
    """One harmonic of the detent torque: T = K sin(2 pi alpha / alpha_det + phi).

    Equation (4) of [Kornienko2013]_ with a phase, which the paper had not; K in N m. The kernel's
    parameters are a = K cos(phi) and b = K sin(phi).

    Parameters
    ----------
    index : int
        Position in the file's list, from 0.
    order : int or None
        Periods per electrical period where that is a whole number: then the sine and cosine come
        from those of the windings by multiple angles. None: the period is used as it is.
    """
    k = index + 1
    a, b, K, phi, period = symbols(f"a_{k} b_{k} K_D{k} phi_{k} alpha_det{k}")
    angle: Expr = order * p / 2 * alpha if order else 2 * pi / (period * pi / 180) * alpha
    return Block(
        name=f"detent_{k}",
        table=f"stepper.detent.{index}",
        declarations=(
            Declaration(
                key="period_deg",
                symbol=period.name,
                unit="deg",
                meaning="detent period",
                lower=1e-6,
                structural=True,
            ),
            Declaration(
                key="amplitude",
                symbol=K.name,
                unit="N m",
                meaning="detent torque amplitude",
                lower=0.0,
                typical=("k_m*U/R", 0.0, 0.2),
            ),
            Declaration(key="phase_deg", symbol=phi.name, unit="deg", meaning="detent phase", default=0.0),
        ),
        coordinates={a: K * cos(phi * pi / 180), b: K * sin(phi * pi / 180)},
        polar=(PolarPair(amplitude="amplitude", phase="phase_deg", cosine=a, sine=b),),
        inputs=(alpha,),
        outputs={"T": a * sin(angle) + b * cos(angle)},
    )


def motor_torque(detents: int) -> Block:
    """T_mot = T_A + T_B - T_D, equation (5) of [Kornienko2013]_; N m."""
    T_coils, T_mot = symbols("T_coils T_mot")
    T_D = symbols(f"T_D1:{detents + 1}")
    return Block(
        name="motor",
        table="stepper",
        inputs=(T_coils, *T_D),
        terms={T_mot: T_coils - sum(T_D)},
        outputs={"T_mot": T_mot},
    )
