"""Spectra of records: distances, and the rates that their own lines suggest."""

from functools import cache

import numpy as np

from mechid.campaign import catalogue_mechanism
from mechid.identification.identify import make_problem
from mechid.identification.readings.spectrum import spectrum_of
from synthetic import COMMANDS, campaign, measured, record, truth

NAMES = ("full_46", "full_23", "micro_46", "micro_92")


SECONDS = 1.0


@cache
def torque(name, seed=7):
    """Return what the demo's mechanism gives in a record, with noise, offset and drift."""
    return measured(truth(), COMMANDS[name], np.random.default_rng((seed, NAMES.index(name))), seconds=SECONDS)


def test_a_low_pass_far_above_a_record_changes_nothing():
    """Truth: the distance without one, also of a record at 1 kHz, all of whose frequencies are looked at."""
    short = record("full_46", torque("full_46")[:2000:10], COMMANDS["full_46"], rate_hz=1000.0)
    sight = spectrum_of(make_problem(campaign(catalogue_mechanism(), short), 1).targets[0])
    np.testing.assert_allclose(
        sight.low_passed_distances(2.0 * sight.power, [1e9]), sight.distances(2.0 * sight.power, [1.0])
    )
