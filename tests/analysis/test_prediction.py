"""A record beside what a fit predicts of it. Truth: the simulation, noise, offset and drift that made the record."""

import numpy as np
import pytest

from fits_by_hand import fit_by_hand
from mechid.analysis.prediction import Travel, predict
from mechid.command import RateProfile, Timing
from mechid.simulation.simulator import TimeBase
from synthetic import COMMANDS, DRIFT_NM, NOISE_NM, OFFSET_NM, RATE_HZ, measured, record, torque_of, truth

NAME, SECONDS = "full_46", 0.3
SAMPLES = round(SECONDS * RATE_HZ) + 1


def predicted(mechanism, **more):
    torque = measured(truth(), COMMANDS[NAME], np.random.default_rng(3), seconds=SECONDS)
    (found,) = predict(record(NAME, torque, COMMANDS[NAME], **more), fit_by_hand(mechanism)).values()
    return torque, found


def test_the_model_is_the_simulation_and_the_residual_is_the_noise():
    """Truth: the simulation at four steps a sample; offset and drift to four of their standard errors."""
    torque, found = predicted(truth())
    np.testing.assert_allclose(found.modelled[:], torque_of(truth(), COMMANDS[NAME], SAMPLES), atol=1e-5)
    np.testing.assert_array_equal(found.measured[:], torque)
    residual = found.residual[:]
    assert residual.std() == pytest.approx(NOISE_NM, rel=4.0 / np.sqrt(2.0 * SAMPLES))
    removed = found.removed.at(0, SAMPLES)
    within = 4.0 * 2.0 * NOISE_NM / np.sqrt(SAMPLES)
    assert removed[0] == pytest.approx(OFFSET_NM, abs=within)
    assert removed[-1] - removed[0] == pytest.approx(DRIFT_NM, abs=2.0 * within)
    np.testing.assert_allclose(found.level[:], torque - removed)
    assert found.evaluated_part is found
    assert found.evaluated_from == 0


def test_without_offset_and_drift_nothing_is_removed():
    """Truth: what is left is the offset and half the drift on average."""
    _, found = predicted(truth(), offset=False, drift=False)
    assert not np.any(found.removed.at(0, SAMPLES))
    assert found.residual[:].mean() == pytest.approx(OFFSET_NM + 0.5 * DRIFT_NM, abs=5.0 * NOISE_NM / np.sqrt(SAMPLES))


def test_a_simulation_that_fails_is_no_number_from_there_on():
    """Damping that no step of a sample can follow diverges."""
    torque, found = predicted(truth({"gear.damping": 1e6}))
    assert not found.finite
    assert np.isnan(found.modelled[:][-1])
    np.testing.assert_array_equal(found.level[:], torque)


def test_the_way_travelled_is_the_integral_of_the_rate():
    """Truth: by hand; 10 steps/s from 0 s on, seen by a recorder that began 0.5 s earlier."""
    travel = Travel(RateProfile.constant(10.0), TimeBase(10.0, 21, -0.5), Timing())
    times = -0.5 + np.arange(21) / 10.0
    np.testing.assert_allclose(travel[:], 10.0 * np.clip(times, 0.0, None), atol=1e-9)
    np.testing.assert_array_equal(travel[5:9], travel[:][5:9])
    assert travel.size == 21
