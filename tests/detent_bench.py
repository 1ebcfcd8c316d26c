"""A synthetic campaign whose mechanism file lacks a detent of 130 periods in a turn of the rotor."""

import numpy as np

from mechid.campaign import catalogue_mechanism
from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from mechid.identification.computation.journal import Journal
from mechid.identification.identify import make_problem
from mechid.identification.stages.families import Families
from mechid.identification.stages.first_look import fit_look
from synthetic import COMMANDS, TRUTH, campaign, measured, record

PERIODS = 130
"""No multiple of the motor's 50 electrical periods, so that no list of the library has it."""
AMPLITUDE_NM, PHASE_DEG = 0.004, 30.0
FREE = ("gear.stiffness", "gear.damping", "stepper.torque_constant", "friction.coulomb")


def detent_bench(seconds=0.12):
    """Return the campaign, its four free parameters at the truth."""
    detent = {"period_deg": 360.0 / PERIODS, "amplitude": AMPLITUDE_NM, "phase_deg": PHASE_DEG}
    stepper = {**CATALOGUE["stepper"], "detent": [*CATALOGUE["stepper"]["detent"], detent]}
    made_by = mechanism_from_table({**CATALOGUE, "stepper": stepper}, "with a detent").with_values(TRUTH)
    records = [
        record(name, measured(made_by, COMMANDS[name], np.random.default_rng((9, k)), seconds=seconds), COMMANDS[name])
        for k, name in enumerate(("full_46", "micro_46", "micro_92"))
    ]
    return campaign(catalogue_mechanism().with_values(TRUTH).with_free(FREE), *records)


def detent_families():
    """Return what may be free beside the mechanism of that campaign."""
    made = detent_bench()
    return Families(make_problem(made, 1), made)


def look_without_the_detent(families):
    """Return what the mechanism as written leaves, from its values moved by 5 %."""
    near = {name: 1.05 * value for name, value in families.plain.coordinates.values(families.plain.start).items()}
    return fit_look(families.bare, families.plain.coordinates.point(near), Journal())
