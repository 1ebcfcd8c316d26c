"""Emission over the number of microsteps, after the calibration assembly of Sentinel-4.

Marquet, Jacobs, Sonderegger, 45th Aerospace Mechanisms Symposium (2020), pp. 241-254: more than 64 microsteps per step
bring nothing. Case E of docs/validation.md.
"""

import numpy as np
import pytest

import mechid
from synthetic import truth

SAMPLE_RATE_HZ = 10_000.0


def emission(microsteps, rate):
    """Return the RMS torque of a mechanism with two detents in N m, from 1 to 2 s."""
    command = mechid.make_command("micro", microsteps=microsteps, rate=rate)
    campaign = mechid.make_campaign(truth(), [mechid.make_record("micro", command=command)])
    run = mechid.simulate(campaign, sample_rate_hz=SAMPLE_RATE_HZ, duration_s=2.0)
    return float(np.std(run.torque[round(SAMPLE_RATE_HZ) :]))


@pytest.mark.parametrize("rate", [20.0, 46.0, 92.0])
def test_more_than_64_microsteps_bring_nothing(rate, note):
    """Published in words; tolerance 5 % from 64 to 128. Below the resonance 16 are coarser by more than that."""
    found = {n: emission(n, rate) for n in (16, 32, 64, 128, 256)}
    note(f"microsteps, RMS in mN m at {rate:g} steps/s: " + ", ".join(f"{n}: {1e3 * y:.4f}" for n, y in found.items()))
    assert found[128] == pytest.approx(found[64], rel=0.05)
    assert found[256] == pytest.approx(found[64], rel=0.05)
    if rate == 20.0:
        assert found[16] > 1.5 * found[64]
