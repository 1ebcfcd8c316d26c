"""Short records of a mechanism that has harmonics of the torque constant which the file of the campaign lacks."""

import numpy as np

from mechid.campaign import catalogue_mechanism
from mechid.campaign.catalogue_values import CATALOGUE
from mechid.campaign.mechanism_file import mechanism_from_table
from synthetic import COMMANDS, TRUTH, campaign, measured, record

USES = ("estimate", "estimate", "estimate", "validate")
HARMONIC = {"order": 3, "amplitude": 0.01, "phase_deg": 40.0}


def tables(*harmonics):
    """Return the catalogue's tables with harmonics of the torque constant."""
    return {**CATALOGUE, "stepper": {**CATALOGUE["stepper"], "torque_harmonic": list(harmonics)}}


def made(*harmonics):
    """Return a campaign of short records, the last held out, whose mechanism file has no harmonic of the constant."""
    made_by = mechanism_from_table(tables(*harmonics), "with harmonics").with_values(TRUTH)
    records = [
        record(n, measured(made_by, COMMANDS[n], np.random.default_rng((9, k)), seconds=0.3), COMMANDS[n], use=use)
        for k, (n, use) in enumerate(zip(("full_46", "full_23", "micro_46", "micro_92"), USES, strict=True))
    ]
    return campaign(catalogue_mechanism(), *records)
