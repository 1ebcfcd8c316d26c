"""Assemblies: which blocks make a mechanism, and how they are wired. Wiring is data."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

from mechid.errors import InputFileError, did_you_mean
from mechid.plant.block import Block
from mechid.plant.drive import voltage_drive
from mechid.plant.drive_train import gear, rigid_load, rotor
from mechid.plant.housing import housing, rigid_housing, transducer
from mechid.plant.plant import Plant, assemble
from mechid.plant.stepper import detent, motor_torque, windings

STEPPER_GEAR_MASS = "stepper_gear_mass"
ASSEMBLIES = (STEPPER_GEAR_MASS,)

WIRING = {
    "windings.u_A": "drive.u_A",
    "windings.u_B": "drive.u_B",
    "windings.alpha": "rotor.alpha",
    "windings.omega": "rotor.omega",
    "motor.T_coils": "windings.T",
    "rotor.T_mot": "motor.T_mot",
    "rotor.T_rg": "gear.T_rg",
    "gear.alpha": "rotor.alpha",
    "gear.omega": "rotor.omega",
    "gear.alpha_gear": "load.alpha_gear",
    "gear.omega_gear": "load.omega_gear",
    "load.T_applied": "gear.T_applied",
    "housing.T_res": "rotor.T_res",
    "transducer.T_residual": "housing.T",
    "transducer.T_applied": "gear.T_applied",
}


def stepper_gear_mass(detent_orders: Sequence[int | None], housing_form: str | None) -> Plant:
    """Return the paper's mechanism (Fig. 2 of [Kornienko2013]_) as a plant.

    Parameters
    ----------
    detent_orders : sequence of int or None
        For each detent harmonic its periods per electrical period, None where not whole.
    housing_form : str or None
        ``"paper"``, ``"unit_dc"``, or None for a rigid housing.
    """
    return _stepper_gear_mass(tuple(detent_orders), housing_form)


@lru_cache(maxsize=32)
def _stepper_gear_mass(detent_orders: tuple[int | None, ...], housing_form: str | None) -> Plant:
    detents = [detent(k, order) for k, order in enumerate(detent_orders)]
    blocks: list[Block] = [
        voltage_drive(),
        windings(),
        *detents,
        motor_torque(len(detents)),
        rotor(),
        gear(),
        rigid_load(),
        housing(housing_form) if housing_form else rigid_housing(),
        transducer(),
    ]
    wiring = dict(WIRING)
    for d in detents:
        wiring[f"{d.name}.alpha"] = "rotor.alpha"
        wiring[f"motor.T_D{d.name.removeprefix('detent_')}"] = f"{d.name}.T"
    return assemble(STEPPER_GEAR_MASS, blocks, wiring, {"torque": "transducer.torque"})


def check_assembly(name: str) -> None:
    """Raise InputFileError if there is no assembly of that name."""
    if name not in ASSEMBLIES:
        raise InputFileError(
            f'assembly: unknown "{name}"{did_you_mean(name, ASSEMBLIES) or "; known: " + ", ".join(ASSEMBLIES)}'
        )
