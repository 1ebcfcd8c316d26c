"""Load of a drive train (test mass): rigid or with flexible modes, with or without friction of its own."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from sympy import Expr, Float, Integer, Symbol, diff, symbols

from mechid.parameter import Declaration, Role
from mechid.plant.block import Block, Rival
from mechid.plant.drive_train import COMMANDED, SWING, G, alpha_gear, beta_acc, omega_gear
from mechid.plant.ports import PUSH
from mechid.plant.start import ANGLE, OUTPUT_TORQUE, RATE, TWIST, TWIST_RATE
from mechid.plant.start import start as own_start

LOAD_ON_GEAR = "load on the gear"
CRAIG_BAMPTON = "Craig, Bampton, AIAA J. 6 (1968) 1313-1319"
_parameter = partial(Declaration, source=CRAIG_BAMPTON)
J_m, T_applied, T_fr, free = symbols("J_m T_applied_in T_fr_out_in free_out_in")
drive, T_load, a_gear = symbols("T_drive_out T_load a_gear")
T_cable, T_unbalance = symbols("T_cable_in T_unbalance_in")
beta_acc_held = Symbol("beta_acc_load_in")
"""Acceleration that the base would have if friction held the load, rad/s2."""
INERTIA = Declaration("inertia", "J_m", "kg m2", "test mass inertia", lower=0.0, role=Role.LOAD_INERTIA)
MEASURED = {"alpha_gear": alpha_gear, "omega_gear": omega_gear}
WIND_UP = f"{OUTPUT_TORQUE}/K_s"
"""Wind-up of the gear under the motor held by one phase, rad at the output."""
MOSTLY_BELOW = 0.2
"""Typical upper limit of the damping ratio of a load's flexible modes: a larger number may be meant in percent."""
STARTS = (
    own_start("twist", TWIST, "rad", "wind-up of the gear at the start, at the output", WIND_UP),
    own_start("twist_rate", TWIST_RATE, "rad/s", "rate at which the gear winds up at the start", f"({SWING})/Abs(G)"),
)
SWINGING = {alpha_gear: LOAD_ON_GEAR, omega_gear: LOAD_ON_GEAR}


def load(
    *,
    modes: int = 0,
    rubbed: bool = False,
    cabled: bool = False,
    unbalanced: bool = False,
    start: Expr = (COMMANDED + ANGLE) / G,
    turns: bool = False,
    pushed: bool = False,
) -> Block:
    """Load on the output, rigid or with flexible modes, with or without friction of its own.

    Rigid and frictionless it is the paper's test mass, J_m alpha_g_ddot = T_applied, equation (10) of [Kornienko2013]_;
    kg m2, rad, N m. Each mode k, seen from the output, is an inertia J_k on a spring with deflection q_k:

        q_k'' + 2 zeta_k omega_k q_k' + omega_k^2 q_k = -A
        (J_m - sum J_k) A = T_applied + sum J_k (omega_k^2 q_k + 2 zeta_k omega_k q_k') - T_fr - T_cable - T_outside

    (cantilever modes with effective inertias J_k; J_m is the total inertia; A = alpha_g'' is the hub's acceleration, on
    a rotating base alpha_g'' + beta''). The base feels T_load = T_applied - T_fr - T_cable, since friction and cables
    act between it and the load. T_outside = T_unbalance - T_port, weight minus external torque, acts from outside.

    Parameters
    ----------
    modes : int
    rubbed : bool
        Whether a friction block acts on it.
    cabled, unbalanced : bool
        Whether cables, or its weight, act on it.
    start : Expr
        Its angle at the start of a record, rad; a function of the rotor's angle if that differs from the commanded one.
    turns : bool
        Whether its base rotates.
    pushed : bool
        Whether an external torque acts on it (`ports`).
    """
    if not (modes or rubbed or cabled or unbalanced or turns or pushed):
        return _test_mass(start)
    flexible = [_Mode(k) for k in range(1, modes + 1)]
    springs = sum((mode.spring for mode in flexible), Integer(0))
    # The file gives the inertia of the whole load; the modes' effective inertias are part of it.
    hub = J_m - sum((mode.J for mode in flexible), Integer(0))
    held = hub * beta_acc_held if turns and rubbed else Integer(0)
    cable = T_cable if cabled else Integer(0)
    outside = (T_unbalance if unbalanced else Integer(0)) - (PUSH if pushed else 0)
    moving: Expr = drive + held
    if rubbed:
        moving = free * (drive + held - T_fr) + ((1 - free) * hub * beta_acc if turns else 0)
    on_base = {
        "T_free_load": T_applied - cable - (T_fr if rubbed else 0),
        "T_held_load": outside - springs,
        "I_load": hub,
    }
    return Block(
        name="load",
        table="load",
        declarations=(INERTIA, *(d for mode in flexible for d in mode.declarations)),
        inputs=(
            T_applied,
            *([T_fr, free] if rubbed else []),
            *([T_cable] if cabled else []),
            *([T_unbalance] if unbalanced else []),
            *([PUSH] if pushed else []),
            *_base_inputs(rubbed=rubbed, turns=turns),
        ),
        terms={
            **{mode.spring: mode.torque for mode in flexible},
            drive: T_applied + springs - cable - outside - held,
            a_gear: moving / hub,
            T_load: moving - springs + outside,
        },
        rates={
            alpha_gear: omega_gear,
            omega_gear: _relative(rubbed=rubbed) if turns else a_gear,
            **{state: rate for mode in flexible for state, rate in mode.rates.items()},
        },
        initial={**_initial(start), **{state: own for mode in flexible for state, own in mode.starts.items()}},
        starts=(*STARTS, *(d for mode in flexible for d in mode.start_declarations)),
        outputs={**MEASURED, "T_drive_out": drive, "T_load": T_load, **(on_base if turns else {})},
        # Hub and gear resonate as the load on the gear, each flexible mode under its own number.
        swinging={**SWINGING, **{state: f"load mode {mode.k}" for mode in flexible for state in mode.rates}},
    )


def _test_mass(start: Expr) -> Block:
    """Return the paper's test mass: rigid and frictionless, on a base at rest."""
    return Block(
        name="load",
        table="load",
        declarations=(INERTIA,),
        inputs=(T_applied,),
        rates={alpha_gear: omega_gear, omega_gear: T_applied / J_m},
        initial=_initial(start),
        starts=STARTS,
        outputs={**MEASURED, "T_load": T_applied},
        swinging=SWINGING,
        rivals=(_dry_friction(),),
    )


def _dry_friction() -> Rival:
    """Return dry friction of the load as an alternative, of a size that winds the gear by microradians."""
    K_s, wound = Symbol("K_s"), Float(4e-6)
    return Rival(
        name="output_friction",
        words="dry friction of the load",
        table="output_friction",
        free={
            "coulomb": (wound * K_s, wound * K_s / 100, wound * K_s * 100),
            "stiction": (wound * K_s / 4, Integer(0), wound * K_s * 2),
        },
    )


def _initial(start: Expr) -> dict[Symbol, Expr]:
    """Return initial angle and rate: those of the rotor through the gear, less the gear's wind-up."""
    return {alpha_gear: start - TWIST, omega_gear: diff(start, ANGLE) * RATE - TWIST_RATE}


def _base_inputs(*, rubbed: bool, turns: bool) -> tuple[Symbol, ...]:
    if not turns:
        return ()
    return (beta_acc, beta_acc_held) if rubbed else (beta_acc,)


def _relative(*, rubbed: bool) -> Expr:
    """Return the hub's acceleration relative to its base; zero while friction holds it."""
    return free * (a_gear - beta_acc) if rubbed else a_gear - beta_acc


@dataclass(frozen=True)
class _Mode:
    """One cantilever mode, counted from 1."""

    k: int

    @property
    def J(self) -> Symbol:
        return Symbol(f"J_{self.k}")

    @property
    def spring(self) -> Symbol:
        return Symbol(f"T_mode{self.k}")

    @property
    def _symbols(self) -> tuple[Symbol, Symbol, Symbol, Symbol]:
        return tuple(Symbol(f"{name}_{self.k}") for name in ("zeta", "omega", "q", "v"))

    @property
    def torque(self) -> Expr:
        zeta_k, omega_k, q_k, v_k = self._symbols
        return self.J * (omega_k**2 * q_k + 2 * zeta_k * omega_k * v_k)

    @property
    def rates(self) -> dict[Symbol, Expr]:
        _, _, q_k, v_k = self._symbols
        return {q_k: v_k, v_k: -self.spring / self.J - a_gear}

    @property
    def starts(self) -> dict[Symbol, Symbol]:
        """Symbols of the start values of its states."""
        return {state: Symbol(f"{state.name}_start") for state in self.rates}

    @property
    def start_declarations(self) -> tuple[Declaration, ...]:
        deflection, rate = self.starts.values()
        word = f"of flexible mode {self.k} at the start"
        return (
            own_start(f"mode_{self.k}", deflection, "rad", f"deflection {word}", WIND_UP),
            own_start(f"mode_{self.k}_rate", rate, "rad/s", f"rate {word}", f"{WIND_UP}*omega_{self.k}"),
        )

    @property
    def declarations(self) -> tuple[Declaration, ...]:
        where, k = f"load.mode.{self.k - 1}", self.k
        return (
            _parameter(
                f"{where}.frequency", f"omega_{k}", "rad/s", "cantilever frequency of a flexible mode", lower=0.0
            ),
            _parameter(
                key=f"{where}.damping",
                symbol=f"zeta_{k}",
                unit="1",
                meaning="damping ratio of a flexible mode",
                lower=0.0,
                percent_above=MOSTLY_BELOW,
            ),
            _parameter(
                key=f"{where}.inertia",
                symbol=f"J_{k}",
                unit="kg m2",
                meaning="effective inertia of a flexible mode, part of the load's",
                lower=0.0,
                part_of="load.inertia",
            ),
        )
