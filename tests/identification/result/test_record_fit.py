"""How well a model predicts a record. Truth: a record that is the model's own torque, a line and known noise."""

import numpy as np
import pytest

from mechid.identification.output_error.noise_level import NoiseSource
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from mechid.identification.result.record_fit import channel_noises, record_fit
from synthetic import COMMANDS, NOISE_NM, RATE_HZ, displaced, record, truth

SAMPLES = 3000
LINE = 0.3 - 2.0 * np.arange(SAMPLES) / RATE_HZ


@pytest.fixture(scope="module")
def made():
    """Return a record, its noise, and the problem of the mechanism that made it."""
    problem = Problem(SearchSpace(displaced(truth(), {"gear.stiffness": 1.0})), ())
    empty = target_of(record("full_46", np.zeros(SAMPLES), COMMANDS["full_46"]))
    (torque,) = problem.model.predict(empty, problem.start, SAMPLES)
    noise = NOISE_NM * np.random.default_rng(4).standard_normal(SAMPLES)
    return record("full_46", torque + LINE + noise, COMMANDS["full_46"]), noise, problem


def test_what_is_left_is_the_noise_less_a_line(made):
    """Truth: least squares of the noise by offset and drift; the share of the measured spread that it leaves."""
    own, noise, problem = made
    phi = np.vander(np.arange(SAMPLES) / RATE_HZ, 2, increasing=True)
    line = np.linalg.lstsq(phi, noise, rcond=None)[0]
    rest = noise - phi @ line
    found = record_fit(own, problem, problem.start, {})
    assert found.residual_rms == pytest.approx(np.sqrt(np.mean(rest**2)), rel=1e-6)
    assert found.offset == pytest.approx(0.3 + line[0], rel=1e-6)
    assert found.drift == pytest.approx(-2.0 + line[1], rel=1e-5)
    spread = np.std(own.data.channels[0].data - phi @ [found.offset, found.drift])
    assert found.fit_percent == pytest.approx(100.0 * (1.0 - found.residual_rms / spread), rel=1e-9)


def test_a_record_is_followed_to_its_end(made):
    own, _, problem = made
    found = record_fit(own, problem, problem.start, {})
    assert found.horizon_s == pytest.approx((SAMPLES - 1) / RATE_HZ)
    assert found.channels["torque"].followed_percent == 100.0


def test_a_window_is_judged_by_its_own_samples(made):
    own, _, problem = made
    found = record_fit(own, problem, problem.start, {"full_46": (500, 1500)})
    assert found.samples == 1000
    assert found.offset == pytest.approx(0.3, abs=5.0 * NOISE_NM)


def test_another_mechanism_leaves_more(made):
    own, _, problem = made
    wrong = Problem(SearchSpace(displaced(truth(), {"gear.stiffness": 1.3})), ())
    found = record_fit(own, wrong, wrong.start, {})
    assert found.residual_rms > 2.0 * record_fit(own, problem, problem.start, {}).residual_rms
    assert found.horizon_s < (SAMPLES - 1) / RATE_HZ


def test_noise_of_a_channel_that_nobody_raised_is_the_one_known(made):
    noise = channel_noises(made[0], ())["torque"]
    assert noise.found == noise.known
    assert noise.follows == noise.known.sigma == pytest.approx(NOISE_NM, rel=0.2)
    assert noise.known.rests_on is NoiseSource.FLOOR
