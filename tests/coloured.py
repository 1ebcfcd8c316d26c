"""Records of the truth in coloured noise, and fits of them held against it."""

import math

import numpy as np
from scipy.signal import lfilter

from mechid.campaign.bench import TRUTH
from mechid.identification.result.grade import FitOutcome
from synthetic import COMMANDS, NOISE_NM, RATE_HZ, record, torque_of, truth

FREE = ("gear.stiffness", "gear.damping", "stepper.torque_constant", "housing.gain")
NEAR = {name: TRUTH[name] for name in FREE}


def coloured(seed, *, hertz, radius, samples, settled=5000):
    """Return two records of the truth in settled noise of an AR(2) process, told by its poles' frequency and radius."""
    rng = np.random.default_rng(seed)
    a = [1.0, -2.0 * radius * math.cos(2.0 * math.pi * hertz / RATE_HZ), radius**2]
    records = []
    for name in ("full_46", "micro_46"):
        noise = lfilter([1.0], a, rng.standard_normal(settled + samples))[settled:]
        torque = torque_of(truth(), COMMANDS[name], samples) + NOISE_NM * noise / noise.std()
        records.append(record(name, torque, COMMANDS[name]))
    return records


def assert_true(fit):
    """See that a fit has converged to the values that made the records, within 5 sigma."""
    assert fit.outcome is FitOutcome.CONVERGED
    for name, value in NEAR.items():
        p = fit.parameters[name]
        assert abs(p.value - value) < 5.0 * p.std_error, name
