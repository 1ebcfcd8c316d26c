"""Fit of a record and its channels. Truth: the ratios and the words, worked out by hand."""

import json
import math

import pytest

from mechid.identification.result.missing_effects import EffectValue
from mechid.identification.result.record_result import ChannelFit, MaskedMoment, Nuisance, RecordFit, masks_of


def channel(**changes):
    entries = {"unit": "N*m", "use": "estimate", "fit_percent": 99.0, "residual_rms": 4e-3, "noise_sigma": 2e-3}
    return ChannelFit(**(entries | {"offset": None, "drift": None} | changes))


def record(channels, **changes):
    entries = {"samples": 100, "fit_percent": 99.0, "residual_rms": 4e-3, "noise_sigma": 2e-3, "horizon_s": 1.0}
    return RecordFit(name="a", use="estimate", offset=None, drift=None, channels=channels, **(entries | changes))


def test_a_raised_noise_level_counts_for_the_channel_and_not_for_the_record():
    raised = channel(noise_sigma=4e-3, noise_known=1e-3)
    assert raised.initial_noise == 1e-3
    assert raised.residual_over_noise == pytest.approx(1.0)
    assert record({"torque": raised}).residual_over_noise == pytest.approx(4.0)
    assert channel(noise_sigma=0.0).residual_over_noise == math.inf


def test_a_channel_lost_or_out_of_step_is_not_followed():
    assert channel().is_followed
    assert not channel(lost_at_s=0.3).is_followed
    assert not channel(out_of_step_at_s=0.3).is_followed


def test_a_record_is_followed_as_far_as_its_worst_channel():
    two = {"torque": channel(followed_percent=98.0), "current": channel(followed_percent=60.0)}
    assert record(two).followed_percent == 60.0
    assert record(two, followed_of_whole=30.0).followed_percent == 30.0
    assert record({}).followed_percent == 100.0


def test_figures_of_a_channel_that_a_record_lacks_are_its_own():
    one = record({"torque": channel(residual_rms=1e-3, lines=((50.0, 0.1, 0.0), (150.0, 0.2, 1.0)))})
    assert (one.residual_of("torque"), one.residual_of("current")) == (1e-3, 4e-3)
    assert one.known_noise_of("current") == 2e-3
    assert one.lines == (50.0, 150.0)


def test_parameters_of_a_held_out_record_come_back_from_json():
    own = {"record.a.gain": EffectValue(value=1.0123456, std_error=2e-4, unit="1")}
    own |= {"record.a.time_offset": EffectValue(value=0.5, std_error=None, unit="s")}
    found = Nuisance(samples=10, until_s=0.1, parameters=own)
    assert Nuisance.from_dict(json.loads(json.dumps(found.to_dict()))) == found
    assert [*found.words()] == ["gain = 1.01235 +- 0.0002 1", "time_offset = 0.5 s"]


def test_moments_left_out_are_those_of_the_channel_that_shows_them_most():
    small, large = (
        MaskedMoment(first=20, stop=30, from_s=2.0, to_s=3.0, largest=0.5, over_noise=over, chi_square=over**2)
        for over in (4.0, 70.0)
    )
    one = record({"torque": channel(masked=(small,)), "rotor_angle": channel(masked=(large,))})
    assert one.masked == (large,)
    assert "one moment was left out" in one.describe_masked()
    assert (
        "2 to 3 s, residual up to 0.5 rad, 70 times the noise; if counted, it would add 4.9e+03"
        in one.describe_masked()
    )
    assert record({"torque": channel()}).describe_masked() == ""
    assert masks_of({"a": one, "b": record({})}) == {"a": ((20, 30),)}
