"""The paper's mechanism and records, as the tests use them: values of its tables and text."""

from collections.abc import Mapping
from types import MappingProxyType

from mechid.command import Command, RateProfile
from mechid.parameter import Parameter
from mechid.plant.assembly import stepper_gear_mass
from mechid.plant.mechanism import Mechanism

ESTIMATED = MappingProxyType(
    {
        "stepper.peak_voltage": 5.7,
        "stepper.poles": 100.0,
        "stepper.coil_resistance": 9.9,
        "stepper.coil_inductance": 0.045,
        "stepper.torque_constant": 0.384,
        "stepper.back_emf_constant": 0.384,
        "stepper.phase_shift_deg": 90.0,
        "stepper.rotor_inertia": 8.9e-6,
        "stepper.detent.0.period_deg": 1.8,
        "stepper.detent.0.amplitude": 0.0047,
        "stepper.detent.0.phase_deg": 35.0,
        "stepper.detent.1.period_deg": 3.6,
        "stepper.detent.1.amplitude": 0.0231,
        "stepper.detent.1.phase_deg": -110.0,
        "friction.static": 0.008,
        "friction.coulomb": 0.0013,
        "friction.viscous": 0.0061,
        "gear.ratio": 50.0,
        "gear.stiffness": 913.47,
        "gear.damping": 0.39,
        "load.inertia": 0.010534,
        "housing.gain": 4.6,
        "housing.frequency": 5578.0,
        "housing.damping": 0.095,
    }
)
"""The paper's estimates; U = 0.6 A x 9.5 ohm and the detents' phases, which it had not, as in the demo."""

SENSITIVE = (
    "R",
    "L",
    "k_m",
    "k_v",
    "a_1",
    "b_1",
    "a_2",
    "b_2",
    "T_frs",
    "T_frd",
    "T_visc",
    "K_s",
    "D",
    "K_res",
    "omega_0",
    "zeta",
)
"""The kernel's parameters that are estimated, and k_v."""


def mechanism(housing: str | None = "paper", orders=(4, 2), changes: Mapping[str, float] | None = None) -> Mechanism:
    """Return the paper's mechanism, with some values changed."""
    plant = stepper_gear_mass(orders, housing)
    values = {**ESTIMATED, **(changes or {})}
    parameters = {
        name: Parameter(name=name, value=values[name], declaration=declaration)
        for name, declaration in plant.declarations.items()
    }
    return Mechanism(plant, parameters, {})


def without_detent_phases(changes: Mapping[str, float] | None = None) -> Mechanism:
    """Return the paper's mechanism as published: the detents have no phases."""
    phases = {"stepper.detent.0.phase_deg": 0.0, "stepper.detent.1.phase_deg": 0.0}
    return mechanism(changes={**phases, **(changes or {})})


def indices(mechanism: Mechanism, names=SENSITIVE) -> tuple[int, ...]:
    """Return the positions of those kernel parameters that the plant has."""
    known = list(map(str, mechanism.plant.parameters))
    return tuple(known.index(name) for name in names if name in known)


def constant(rate: float, *, microsteps: int = 1, start_angle_deg: float = 45.0) -> Command:
    """Return the command of one rate, in full steps or microsteps."""
    return Command(
        stepping="full" if microsteps == 1 else "micro",
        microsteps=microsteps,
        rate=RateProfile.constant(rate),
        start_angle_deg=start_angle_deg,
    )


SWEEP = Command(stepping="micro", microsteps=16, rate=RateProfile.through([(0.0, 0.0), (60.0, 120.0)]))
"""The 60 s sweep from 0 to 120 steps/s."""

RECORDS = MappingProxyType(
    {
        "full_5": constant(5.0),
        "full_23": constant(23.0),
        "full_46": constant(46.0),
        "full_92": constant(92.0),
        "micro_46": constant(46.0, microsteps=16),
        "sweep": SWEEP,
    }
)
