"""The ten campaigns: the true mechanism of each, its effects that the task sheet does not list, its noise.

All is drawn from the campaign's own seed, so that no answer stands here as a number. Ranges of the effects are those
that hardware fixes (`incomplete.hardware`).
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from incomplete.effects import log_uniform, phase, signed
from incomplete.plant import Values

from ..mechid_benchmark.tasks import CAMPAIGNS

SEED = 20261127
SUPPLY_V, HALF_POLES, ROTOR_INERTIA, GEAR_RATIO, LOAD_INERTIA = 5.7, 50.0, 8.9e-6, 50.0, 0.010534
"""Known values, in SI units; they stand in every task sheet."""
DETENT_PERIODS_DEG = (1.8, 3.6)
Draw = Callable[[np.random.Generator], Mapping[str, float]]
"""From a generator to sizes in SI units: fields of `Values`, or of `measurement.measured`."""


@dataclass(frozen=True)
class Campaign:
    """One campaign.

    Attributes
    ----------
    kind : str
        What the table in the docs says of it; the task sheet does not.
    effects : tuple of callable
        Draws of the effects that the sheet's mechanism lacks.
    noise : str
        Key of `measurement.NOISES`.
    bad_record : bool
        Whether the transducer works loose in one of the records.
    """

    kind: str
    effects: tuple[Draw, ...] = ()
    noise: str = "white"
    bad_record: bool = False


def _torque_harmonic(rng: np.random.Generator) -> Mapping[str, float]:
    return {"harmonic_order": 3.0, "harmonic": log_uniform(rng, 0.01, 0.06), "harmonic_phase": phase(rng)}


def _kinematic_error(rng: np.random.Generator) -> Mapping[str, float]:
    return {
        "kinematic_order": float(rng.integers(1, 5)),
        "kinematic": log_uniform(rng, 3e-5, 2e-4),
        "kinematic_phase": phase(rng),
    }


def _stribeck(rng: np.random.Generator) -> Mapping[str, float]:
    return {"stribeck_rate": log_uniform(rng, 1.0, 4.0)}


def _phase_offset(rng: np.random.Generator) -> Mapping[str, float]:
    return {f"offset_{name}": SUPPLY_V * signed(rng, 5e-3, 0.03) for name in "AB"}


def _imbalance(rng: np.random.Generator) -> Mapping[str, float]:
    return {"r_k": 0.5 * signed(rng, 0.02, 0.05)}


def _output_friction(rng: np.random.Generator) -> Mapping[str, float]:
    coulomb = log_uniform(rng, 4e-3, 2e-2)
    return {"output_coulomb": coulomb, "output_stiction": rng.uniform(0.0, 0.5) * coulomb}


def _detent(rng: np.random.Generator) -> Mapping[str, float]:
    order = float(rng.choice([50, 150, 250, 300, 350, 400]))
    return {"detent_order_3": order, "detent_3": log_uniform(rng, 1e-3, 6e-3), "detent_phase_3": phase(rng)}


def _mains_hum(rng: np.random.Generator) -> Mapping[str, float]:
    return {"mains_Nm": log_uniform(rng, 2e-3, 6e-3)}


TABLE: Mapping[str, Campaign] = dict(
    zip(
        CAMPAIGNS,
        (
            Campaign("complete, white noise"),
            Campaign("lacks harmonic 3 of the torque constant", (_torque_harmonic,)),
            Campaign("lacks a kinematic error of the gear", (_kinematic_error,)),
            Campaign("lacks Stribeck friction", (_stribeck,)),
            Campaign("lacks offsets of the phase voltages", (_phase_offset,)),
            Campaign("lacks two: phases apart, dry friction at the output", (_imbalance, _output_friction)),
            Campaign("lacks two: a third detent, mains hum", (_detent, _mains_hum)),
            Campaign("complete, noise of a real bench", noise="bench"),
            Campaign("complete, noise of a transducer's resonance", noise="resonant"),
            Campaign("complete, one bad record", bad_record=True),
        ),
        strict=True,
    )
)
"""By number. Mains hum, noise and the bad record are of the bench: held-out emission is without them."""


def rng_of(number: str, stream: int) -> np.random.Generator:
    """Return the generator of a campaign's stream: 0 mechanism, 1 effects, 2 measurement, 3 tap test."""
    return np.random.default_rng((SEED, int(number), stream))


def truth_of(number: str) -> dict[str, float]:
    """Return the true values of the asked parameters, in the task sheet's units."""
    rng = rng_of(number, 0)
    coulomb = log_uniform(rng, 1e-3, 15e-3)
    return {
        "stepper.coil_resistance": 9.5 * rng.uniform(0.95, 1.1),
        "stepper.coil_inductance": 0.0229 * log_uniform(rng, 0.8, 2.2),
        "stepper.torque_constant": 0.277 * rng.uniform(0.9, 1.45),
        "stepper.detent.0.amplitude": rng.uniform(2e-3, 12e-3),
        "stepper.detent.0.phase_deg": rng.uniform(-180.0, 180.0),
        "stepper.detent.1.amplitude": rng.uniform(2e-3, 25e-3),
        "stepper.detent.1.phase_deg": rng.uniform(-180.0, 180.0),
        "friction.static": coulomb + rng.uniform(2e-3, 8e-3),
        "friction.coulomb": coulomb,
        "friction.viscous": log_uniform(rng, 8e-4, 7e-3),
        "gear.stiffness": rng.uniform(850.0, 2300.0),
        "gear.damping": log_uniform(rng, 0.25, 0.9),
        "housing.gain": rng.uniform(2.5, 6.0),
        "housing.frequency": rng.uniform(4600.0, 6400.0),
        "housing.damping": rng.uniform(0.04, 0.12),
    }


def sizes_of(number: str) -> dict[str, float]:
    """Return the sizes of a campaign's effects, in SI units."""
    rng = rng_of(number, 1)
    return {key: value for draw in TABLE[number].effects for key, value in draw(rng).items()}


def resonance_of(number: str) -> float:
    """Return the resonance about which a campaign is tested, Hz: the load on the gear's spring, by a tap test.

    The tap test is up to 5 % off, so that the rates do not tell the stiffness.
    """
    share = rng_of(number, 3).uniform(0.95, 1.05)
    return share * math.sqrt(truth_of(number)["gear.stiffness"] / LOAD_INERTIA) / (2.0 * math.pi)


def values_of(parameters: Mapping[str, float], sizes: Mapping[str, float]) -> Values:
    """Return the simulator's values of asked parameters and effects; sizes of the bench are left out."""
    value = parameters.__getitem__
    detents = {}
    for k, period in enumerate(DETENT_PERIODS_DEG):
        detents[f"detent_order_{k + 1}"] = 360.0 / period
        detents[f"detent_{k + 1}"] = value(f"stepper.detent.{k}.amplitude")
        detents[f"detent_phase_{k + 1}"] = math.radians(value(f"stepper.detent.{k}.phase_deg"))
    return Values(
        U=SUPPLY_V,
        half_poles=HALF_POLES,
        J_rot=ROTOR_INERTIA,
        R=value("stepper.coil_resistance"),
        L=value("stepper.coil_inductance"),
        k_m=value("stepper.torque_constant"),
        static=value("friction.static"),
        coulomb=value("friction.coulomb"),
        viscous=value("friction.viscous"),
        G=GEAR_RATIO,
        K_s=value("gear.stiffness"),
        D=value("gear.damping"),
        J_m=LOAD_INERTIA,
        K_res=value("housing.gain"),
        w_0=value("housing.frequency"),
        zeta=value("housing.damping"),
        **detents,
        **{key: number for key, number in sizes.items() if key in Values._fields},
    )
