"""Truth: records made from a known mechanism with known noise, offset and drift, predicted by itself or another."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from fits_by_hand import fit_by_hand
from mechid.analysis import validate, with_validation
from mechid.command import Command, RateProfile
from mechid.identification.identify import make_problem
from mechid.identification.result.record_fit import record_fit
from synthetic import COMMANDS, NOISE_NM, campaign, measured, record, torque_of, truth

NAME = "full_46"


def fit_at(mechanism, parameters=None):
    """Return a fit that stopped at a mechanism."""
    return fit_by_hand(mechanism, parameters=parameters or {})


def made(mechanism, seed=1, **more):
    torque = measured(mechanism, COMMANDS[NAME], np.random.default_rng(seed), seconds=1.0)
    return campaign(mechanism, record(NAME, torque, COMMANDS[NAME], **more))


def torque_channel(of, mechanism):
    return validate(of, fit_at(mechanism))[NAME].channels["torque"]


def test_the_true_mechanism_leaves_the_noise():
    """10 001 samples of white noise of 2 mN m, offset and drift gone: RMS within 4 of its standard errors."""
    found = torque_channel(made(truth(), use="validate"), truth())
    assert found.residual_rms == pytest.approx(NOISE_NM, rel=4.0 / math.sqrt(2.0 * 10_001))
    assert found.theil.bias < 1e-20
    assert found.theil.covariance > 0.99
    assert found.whiteness.p_value > 1e-3
    assert found.effective_samples > 9000.0
    assert all(abs(e.amplitude_error_percent) < 3.0 for e in found.orders if e.order <= 2.0)
    in_bands = math.sqrt(sum(b.residual_rms**2 for b in found.bands))
    assert 0.9 * NOISE_NM < in_bands < 1.05 * NOISE_NM  # the lowest frequencies and the last part band are left out


def test_a_stiffer_gear_leads_or_lags_and_is_coloured():
    """Truth: the order amplitudes of two simulations without noise."""
    stiff = truth({"gear.stiffness": 960.0})
    found = torque_channel(made(truth()), stiff)
    assert found.whiteness.p_value < 1e-12
    assert found.effective_samples < 100.0
    pure = torque_channel(
        campaign(truth(), record(NAME, torque_of(truth(), COMMANDS[NAME], 10_001), COMMANDS[NAME])), stiff
    )
    for noisy, exact in zip(found.orders, pure.orders, strict=True):
        assert noisy.modelled == pytest.approx(exact.modelled, rel=1e-6)
        if noisy.order == 1.0:
            assert noisy.amplitude_error_percent == pytest.approx(exact.amplitude_error_percent, abs=0.1)
            assert noisy.phase_error_deg == pytest.approx(exact.phase_error_deg, abs=0.1)
            assert abs(exact.phase_error_deg) > 1.0


def test_an_offset_that_is_kept_is_bias():
    """Truth: b^2 / (b^2 + sigma^2), b the mean of an offset of 10 mN m and a drift of 4 mN m over the record."""
    found = torque_channel(made(truth(), offset=False, drift=False), truth())
    spread = 0.004**2 / 12.0
    assert found.theil.bias == pytest.approx(0.012**2 / (0.012**2 + spread + NOISE_NM**2), rel=0.01)


def test_it_says_what_the_fit_says_of_the_same_record():
    """Truth: fit percent and residual of `RecordFit`, simulated on another path."""
    of = made(truth())
    problem = make_problem(of, 1)
    own = record_fit(of.records[0], problem, problem.start, {})
    found = torque_channel(of, truth())
    assert found.fit_percent == pytest.approx(own.fit_percent, abs=1e-3)
    assert found.residual_rms == pytest.approx(own.residual_rms, rel=1e-3)


def test_a_time_offset_that_was_estimated_is_used():
    """3 ms late: predicted with the estimate it is noise, without it is not."""
    late = torque_of(truth(), COMMANDS[NAME], 10_001, time_offset_s=0.003)
    of = campaign(truth(), record(NAME, late, COMMANDS[NAME], time_offset={"value": 0.0, "min": -0.01, "max": 0.01}))
    name = of.records[0].time_offset.name
    estimated = fit_at(truth(), {name: SimpleNamespace(value=0.003)})
    assert validate(of, estimated)[NAME].channels["torque"].residual_rms < 1e-4
    assert torque_channel(of, truth()).residual_rms > 0.01


def test_equal_samples_have_equal_digests_and_others_do_not():
    first = torque_channel(made(truth()), truth())
    again = torque_channel(made(truth(), use="validate"), truth({"gear.stiffness": 960.0}))
    assert first.samples_sha256 == again.samples_sha256
    assert first.samples_sha256 != torque_channel(made(truth(), seed=2), truth()).samples_sha256
    assert first.samples_sha256 != torque_channel(made(truth(), rate_hz=9_999.0), truth()).samples_sha256


@pytest.mark.filterwarnings("error")
def test_a_simulation_that_fails_has_no_numbers():
    """Damping that no step of a sample can follow diverges."""
    wild = truth({"gear.damping": 1e9})
    found = torque_channel(made(truth()), wild)
    numbers = (found.fit_percent, found.residual_rms, found.theil.coefficient, found.whiteness.p_value)
    assert all(math.isnan(number) for number in numbers)
    assert (found.bands, found.orders) == ((), ())


def test_a_slow_record_has_no_orders():
    command = Command(stepping="full", microsteps=1, rate=RateProfile.constant(3.0))
    of = campaign(truth(), record(NAME, torque_of(truth(), command, 5001), command))
    assert torque_channel(of, truth()).orders == ()


def test_estimate_json_gets_a_table_under_each_record():
    """Truth: the contract: what stood there stays as it was."""
    before = {"format": "f", "records": {NAME: {"use": "estimate", "samples": 3}, "other": {"use": "validate"}}}
    of = made(truth())
    after = with_validation(before, validate(of, fit_at(truth())))
    table = after["records"][NAME].pop("validation")
    assert after == before
    assert table["command"]["waveform"] == "cosine"
    assert set(table["channels"]) == {"torque"}
    assert table["channels"]["torque"]["ljung_box"]["lags"] == 25
