"""Forty fits of models that lack nothing, from the catalogue: random mechanisms of two families, the block library.

The records are made anew each time, from the truth and seeds; `stored_fits` holds what is found from them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from complete_benches import NOISE, RUNS, Bench, driven, written
from layouts import LAYOUTS, SINGLE_STEPPER, changed, paper_table
from mechid.campaign import Campaign
from recovery.campaigns import campaign
from recovery.mechanisms import FAMILIES

MOTOR = ("stepper.coil_inductance", "stepper.torque_constant", "friction.viscous")
GEARED = (*MOTOR, "gear.stiffness", "gear.damping")
COULOMB = (*GEARED, "friction.coulomb")
RETURN = {**RUNS, "back_46": 'stepping = "full", rate = -46.0, start_angle_deg = 45.0'}
CHAIN = {
    "transducer": {"law": "adaptor", "gain": -1.1, "stiffness": 2.0e4, "adaptor_inertia": 1e-4, "damping": 0.05},
    "charge_amplifier": {"time_constant": 0.15},
    "anti_alias": {"frequency": 16000.0, "order": 4},
}
OWN_CHAINS = {
    "full_5": {"transducer.gain": -1.07, "time_offset_s": 4.3e-4},
    "full_46": {"transducer.gain": 0.94, "charge_amplifier.time_constant": 0.22, "time_offset_s": -2.7e-4},
    "micro_46": {"transducer.gain": -1.02, "time_offset_s": 1.1e-4},
}
"""Of each record: its gain, the polarity of one reversed, its delay, and of one the time constant."""


@dataclass(frozen=True)
class Case:
    """How a campaign is made in an empty folder, and the true values of what is free in it."""

    campaign: Callable[[Path], Campaign]
    truth: Callable[[], Mapping[str, float]]


def drawn(family: int, seed: int, variant: str = "all") -> Case:
    """Return the case of a random mechanism, all of whose records are there or but one."""

    def truth() -> Mapping[str, float]:
        return {q.name: q.value for q in FAMILIES[family].truth(seed).free}

    def made(_: Path) -> Campaign:
        return campaign(FAMILIES[family].catalogue(), FAMILIES[family].truth(seed), seed, variant)

    return Case(made, truth)


def case(bench: Bench, made: Callable[[Path, Bench], Campaign] = written) -> Case:
    """Return the case of a bench."""
    return Case(partial(made, bench=bench), lambda: bench.truth)


def table(*layouts: Mapping) -> dict:
    """Return the paper's mechanism file with layouts put over it."""
    result = paper_table()
    for layout in layouts:
        result = changed(result, layout)
    return result


def entries(list_name: str, count: int, *keys: str) -> tuple[str, ...]:
    """Return the dotted names of keys of a list's first entries."""
    return tuple(f"{list_name}.{k}.{key}" for k in range(count) for key in keys)


def with_spikes(y: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return samples of which five are far off."""
    out = y.copy()
    out[rng.choice(np.arange(50, y.size - 50), 5, replace=False)] += 100.0 * NOISE["torque"]
    return out


def coloured(y: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return samples with a second noise, of first order."""
    return y + lfilter([1.0], [1.0, -0.6], 0.5 * NOISE["torque"] * rng.standard_normal(y.size))


FRICTIONS = {
    "stribeck": Bench(
        seed=101, table=table(LAYOUTS["stribeck"]), free=(*COULOMB, "friction.static", "friction.stribeck_rate")
    ),
    "directional": Bench(
        seed=102,
        table=table(LAYOUTS["directional"]),
        commands=RETURN,
        free=(*COULOMB, "friction.asymmetry", "friction.viscous_asymmetry"),
    ),
    "load_dependent": Bench(seed=103, table=table(LAYOUTS["load_dependent"]), free=(*COULOMB, "friction.load_share")),
    "lugre": Bench(seed=104, table=table(LAYOUTS["lugre"]), free=(*COULOMB, "friction.bristle_stiffness")),
    "output_friction": Bench(
        seed=105,
        table=table(LAYOUTS["output_friction"]),
        free=(*GEARED, "output_friction.coulomb", "output_friction.viscous"),
    ),
}
DRIVE_TRAINS = {
    "piecewise_gear": Bench(
        seed=111,
        table=table(LAYOUTS["piecewise_linear"], {"gear": {"torque_1": 0.04, "torque_2": 0.12}}),
        free=(*MOTOR, "gear.damping", "gear.stiffness_1", "gear.stiffness_2", "gear.stiffness_3"),
    ),
    "backlash": Bench(seed=112, table=table(LAYOUTS["backlash"]), free=(*GEARED, "gear.backlash")),
    "kinematic_error": Bench(
        seed=113,
        table=table(LAYOUTS["kinematic_error"]),
        free=(*GEARED, *entries("gear.kinematic_error", 2, "amplitude", "phase_deg")),
    ),
    "flexible_load": Bench(
        seed=114,
        table=table(LAYOUTS["flexible load"]),
        free=(*GEARED, *entries("load.mode", 2, "frequency", "damping", "inertia")),
    ),
    "imbalance_torque_harmonics": Bench(
        seed=115,
        table=table(LAYOUTS["imbalance"], LAYOUTS["torque_harmonic"]),
        free=(
            *GEARED,
            "stepper.imbalance.torque_constant",
            "stepper.imbalance.offset_a",
            *entries("stepper.torque_harmonic", 2, "amplitude", "phase_deg"),
        ),
    ),
    "own_blocks": Bench(
        seed=116,
        table=table(
            {
                "housing": None,
                "friction": None,
                "load": {"block": "gravity.py:unbalanced_load", "unbalance": 0.5},
            }
        )
        | {"friction": {"block": "grease.py:grease", "dry": 0.004, "grease": 0.006, "thinning_rate": 20.0}},
        free=(
            "stepper.torque_constant",
            "gear.stiffness",
            "gear.damping",
            "friction.dry",
            "friction.grease",
            "load.unbalance",
        ),
    ),
}
STANDS = {
    "measuring_chain": Bench(
        seed=121,
        table=table(CHAIN),
        free=(
            *GEARED,
            "transducer.gain",
            "transducer.adaptor_inertia",
            "transducer.damping",
            "charge_amplifier.time_constant",
            "anti_alias.frequency",
        ),
    ),
    "own_measuring_chains": Bench(
        seed=122, table=table(CHAIN), free=(*GEARED, "charge_amplifier.time_constant"), own=OWN_CHAINS
    ),
    "torque_angle_current": Bench(
        seed=123,
        table=table(),
        quantities=("torque", "output_angle", "current_phase_b"),
        seconds=0.4,
        free=(*COULOMB, "stepper.coil_resistance", "stepper.peak_voltage"),
    ),
    "priors_and_spikes": Bench(
        seed=124,
        table=table(),
        free=COULOMB,
        sigma={"gear.damping": 0.02, "friction.coulomb": 1e-3},
        options='spikes = "reject"',
        disturbed=with_spikes,
    ),
    "coloured_noise": Bench(seed=125, table=table(), free=COULOMB, disturbed=coloured),
}
SHAFT = Bench(
    seed=131,
    table={"assembly": "current_driven_stepper", **SINGLE_STEPPER},
    quantities=("rotor_angle",),
    free=(
        "stepper.torque_constant",
        "friction.viscous",
        "friction.coulomb",
        *entries("stepper.detent", 1, "amplitude", "phase_deg"),
    ),
)
"""A stepper without gear."""
SLIDE = Bench(
    seed=133,
    quantities=("position",),
    free=("load.mass", "friction.coulomb", "friction.viscous", "drive.offset"),
    table={
        "assembly": "direct_force_drive",
        "load": {"mass": 95.0},
        "drive": {"offset": -3.0},
        "friction": {"static": 25.0, "coulomb": 20.0, "viscous": 200.0},
    },
)
PENDULUM = Bench(
    seed=135,
    quantities=("output_angle",),
    free=("load.inertia", "load.unbalance", "friction.coulomb", "friction.viscous"),
    table={
        "assembly": "direct_torque_drive",
        "load": {"inertia": 0.02, "unbalance": 0.3},
        "drive": {"offset": 0.01},
        "friction": {"static": 0.03, "coulomb": 0.02, "viscous": 0.01},
    },
)
TWO_MASSES = Bench(
    seed=134,
    quantities=("rotor_angle",),
    free=("motor.inertia", "load.inertia", "friction.coulomb", "friction.viscous", "gear.stiffness", "gear.damping"),
    table={
        "assembly": "two_mass_drive",
        "motor": {"inertia": 1e-4},
        "load": {"inertia": 2e-3},
        "drive": {},
        "friction": {"static": 0.012, "coulomb": 0.01, "viscous": 1e-3},
        "gear": {"ratio": 1, "stiffness": 20.0, "damping": 0.02},
    },
)
CASES: Mapping[str, Case] = {
    **{f"family_1_seed_{seed}": drawn(1, seed) for seed in (0, 1, 2, 3, 4, 5, 6, 7, 9, 10)},
    **{f"family_1_seed_{seed}_without_slow": drawn(1, seed, "slow") for seed in (40, 41)},
    **{f"family_1_seed_{seed}_without_sweep": drawn(1, seed, "sweep") for seed in (40, 41)},
    **{f"family_2_seed_{seed}": drawn(2, seed) for seed in range(4)},
    "family_2_seed_10_without_slow": drawn(2, 10, "slow"),
    "family_2_seed_10_without_sweep": drawn(2, 10, "sweep"),
    **{name: case(bench) for name, bench in {**FRICTIONS, **DRIVE_TRAINS, **STANDS}.items()},
    "current_driven_stepper": case(SHAFT),
    "direct_force_drive": case(SLIDE, partial(driven, pull="force", size=60.0)),
    "direct_torque_drive": case(PENDULUM, partial(driven, pull="torque", size=0.3)),
    "two_mass_drive": case(TWO_MASSES, partial(driven, pull="torque", size=0.1)),
}
"""By the name under which the fit is stored."""
