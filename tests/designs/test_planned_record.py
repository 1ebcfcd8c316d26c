"""Records that are planned. Truth: the files that are there, and what docs/files.md says of those that are not."""

import numpy as np
import pytest

import mechid
from mechid.campaign.bench import TRUTH
from mechid.designs.planned_record import PlannedRecord, Recording, planned_records
from mechid.designs.settings import DESIGN

COMMAND = mechid.make_command("full", rate=46.0, start_angle_deg=45.0)
RATE_HZ, SAMPLES, NOISE = 5000.0, 1001, 0.004


@pytest.fixture(scope="module")
def campaign():
    """Return a campaign of a record that was taken, white noise alone, and one that was not."""
    mechanism = mechid.catalogue_mechanism().with_values(TRUTH)
    samples = np.random.default_rng(1).normal(0.0, NOISE, SAMPLES)
    taken = mechid.make_record("taken", samples, sample_rate_hz=RATE_HZ, command=COMMAND)
    return mechid.make_campaign(mechanism, [taken, mechid.make_record("planned", command=COMMAND)])


def test_a_record_that_was_taken_is_as_it_is_and_lends_its_rate_and_noise(campaign):
    """Truth: the samples; the noise's sigma is known to 1/sqrt(2 n)."""
    (taken, planned), said = planned_records(campaign, Recording(duration_s=3.0))
    assert (taken.sample_rate_hz, taken.base.samples) == (RATE_HZ, SAMPLES)
    assert taken.sigma == pytest.approx(NOISE, rel=0.1)
    assert (planned.sample_rate_hz, planned.duration_s, planned.sigma) == (RATE_HZ, 3.0, taken.sigma)
    assert planned.linear == 2
    assert said == ()


def test_what_is_asked_for_goes_before_what_was_seen(campaign):
    recording = Recording(noise_Nm=0.01, sample_rate_hz=2000.0, durations_s={"planned": 7.0})
    for record in planned_records(campaign, recording)[0]:
        assert (record.sigma, record.sample_rate_hz) == (0.01, 2000.0)
    assert planned_records(campaign, recording)[0][1].duration_s == 7.0


def test_a_noise_that_nobody_has_named_is_said_to_be_assumed():
    alone = mechid.make_campaign(mechid.catalogue_mechanism(), [mechid.make_record("planned", command=COMMAND)])
    (planned,), said = planned_records(alone, Recording())
    assert planned.sigma == DESIGN.noise_nm
    assert said == (f"the noise is assumed, {DESIGN.noise_nm:g} N m a sample; write noise_Nm in the design file",)


def test_both_ends_of_a_record_are_samples():
    """Truth: 2 s at 1 kHz are 2001 samples; nothing is measured, so that only the weights count."""
    record = PlannedRecord(name="a", command=COMMAND, duration_s=2.0, sample_rate_hz=1000.0, linear=1)
    target = record.target()
    assert record.base.samples == target.base.samples == 2001
    (channel,) = target.channels
    assert not np.any(channel.measured[:])
    assert (channel.sigma, channel.linear) == (DESIGN.noise_nm, 1)
