"""Mechanisms whose kernels are kept as text: together they have every assembly, law, list and optional table.

Each is a mechanism file, so that a name here holds whatever becomes of the code that reads it.
"""

from collections.abc import Mapping
from pathlib import Path

from layouts import BRUSHED_DC, LAYOUTS, SINGLE_STEPPER, changed, mechanism_of, paper_table
from mechid.campaign import load_mechanism
from mechid.campaign.catalogue_values import CATALOGUE
from mechid.plant.plant import Plant

OWN_BLOCKS = Path(__file__).resolve().parents[1] / "examples" / "own_block" / "mechanism.toml"
FRICTION = {"static": 0.01, "coulomb": 0.005, "viscous": 1e-3}
STRIBECK = {**FRICTION, "law": "stribeck", "stribeck_rate": 2.0}
DIRECTIONAL = {**FRICTION, "law": "directional", "asymmetry": 0.2}
SINGLE = {"assembly": "current_driven_stepper", **SINGLE_STEPPER}
TWO_MASSES = {
    "assembly": "two_mass_drive",
    "motor": {"inertia": 1e-4},
    "friction": FRICTION,
    "drive": {},
    "gear": {"ratio": 1, "stiffness": 50.0, "damping": 0.1},
    "load": {"inertia": 1e-3},
}
STAR_HARMONICS = [{"order": order, "amplitude": 0.03, "phase_deg": 20.0} for order in (5, 7)]
THREE_PHASES = {"phases": 3, "phase_shift_deg": None, "torque_harmonic": STAR_HARMONICS}
ODD_PERIOD = {"stepper": {"detent": [{"period_deg": 2.5, "amplitude": 0.01, "phase_deg": 10.0}]}}
"""A detent whose period goes into an electrical one no whole number of times: its sine is one of its own."""


def with_layouts(*names: str, **tables: object) -> dict:
    """Return the paper's file changed by layouts of the block library by name, and by further tables."""
    table = paper_table()
    for changes in (*(LAYOUTS[name] for name in names), tables):
        table = changed(table, changes)
    return table


VARIANTS: Mapping[str, Mapping] = {
    "paper": CATALOGUE,
    "paper_rigid_odd_detent": with_layouts(housing=None, **ODD_PERIOD),
    "stribeck_piecewise_gear": with_layouts("stribeck", "piecewise_linear", housing={"form": "unit_dc"}),
    "directional_backlash_output_friction": with_layouts("directional", "backlash", "output_friction"),
    "load_dependent_kinematic_error": with_layouts("load_dependent", "kinematic_error"),
    "friction_by_direction": with_layouts("friction by direction"),
    "tooth_mesh": with_layouts("tooth mesh"),
    "unbalance_cable": with_layouts("unbalance", "cable"),
    "cable_spring_output_friction_flexible_load": with_layouts("cable spring", "output_friction", "flexible load"),
    "lugre_flexible_load": with_layouts(
        "lugre", "flexible load", stepper={"drive": "measured_voltage", "peak_voltage": None}
    ),
    "imbalance_torque_harmonics": with_layouts(
        "imbalance", "torque_harmonic", transducer={"law": "resonance", "frequency": 9000.0, "damping": 0.02}
    ),
    "table_supply_saliency_position_second_mode": with_layouts(
        "microstep table", "supply", "saliency", "friction position", "second mode"
    ),
    "current_limit": with_layouts("current limit", "detent hysteresis"),
    "chopper": with_layouts("current limit", stepper={"chop": {"frequency_hz": 2e4, "decay": "mixed", "fast_s": 1e-5}}),
    "pulses": with_layouts(stepper={"pulses": {"on_s": 0.005, "clamp_V": 3.0}}),
    "unipolar_pulses": with_layouts(
        stepper={"phases": 4, "pulses": {"on_s": 0.005, "clamp_V": 3.0, "between": "open_both_ways"}}
    ),
    "three_phases_supply": with_layouts("supply", stepper=THREE_PHASES),
    "measuring_chain": with_layouts("test stand"),
    "current_drive_imbalance_harmonics": with_layouts(
        "torque_harmonic", "current drive", stepper={"imbalance": {"torque_constant": 0.04}}, transducer={"gain": -1.0}
    ),
    "current_driven_stepper": SINGLE,
    "current_driven_stepper_measured": changed(
        SINGLE, {"stepper": {"drive": "measured_current", "peak_current": None}, "friction": STRIBECK}
    ),
    "direct_torque_drive": {
        "assembly": "direct_torque_drive",
        "load": {"inertia": 1e-3},
        "friction": DIRECTIONAL,
        "drive": {},
    },
    "direct_force_drive": {
        "assembly": "direct_force_drive",
        "load": {"mass": 95.0},
        "friction": FRICTION,
        "drive": {},
    },
    "two_mass_drive": TWO_MASSES,
    "brushed_dc_drive": {"assembly": "brushed_dc_drive", **BRUSHED_DC},
    "brushed_dc_drive_spring_housing": changed(
        {"assembly": "brushed_dc_drive", **BRUSHED_DC},
        {
            "spring": {"stiffness": 0.05},
            "friction": STRIBECK,
            "transducer": {"gain": -1.0},
            "housing": {"form": "unit_dc", "gain": 2.0, "frequency": 5000.0, "damping": 0.05},
        },
    ),
    "two_mass_drive_backlash": changed(
        TWO_MASSES, {"gear": {"law": "backlash", "backlash": 1e-3}, "output_friction": {"coulomb": 0.01}}
    ),
}
"""Mechanism files as read from TOML, by the name of their text."""
CHANNELS = "paper_all_channels"
"""The paper's mechanism with everything measured that can be."""
OWN = "own_blocks"
"""The tutorial's mechanism, which has blocks of the user's own."""
NAMES = (*VARIANTS, CHANNELS, OWN)


def plant_named(name: str) -> Plant:
    """Return the plant of a variant."""
    if name == OWN:
        return load_mechanism(OWN_BLOCKS).plant
    if name == CHANNELS:
        plant = mechanism_of(CATALOGUE).plant
        return plant.with_outputs(tuple(plant.offered))
    return mechanism_of(VARIANTS[name]).plant
