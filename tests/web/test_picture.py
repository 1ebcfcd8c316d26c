"""A record beside the model. Truth: the simulation itself, its differences, the Jacobian of the fit."""

import numpy as np
import pytest

import synthetic
from mechid.identification.identify import make_problem
from mechid.web.state import campaign_at
from turned import TRUTH, at_truth


def test_a_picture_is_the_simulation_of_the_settings_and_its_residual_is_the_noise(session):
    """Truth: the bench's own simulation, four steps a sample, and the noise that it drew."""
    picture = at_truth(session).pictures()["full_46"]
    torque = synthetic.torque_of(synthetic.truth(), synthetic.COMMANDS["full_46"], 3001)
    assert np.abs(picture.modelled - torque).max() < 1e-4
    assert picture.numbers.residual.residual_rms == pytest.approx(synthetic.NOISE_NM, rel=0.05)
    assert picture.numbers.residual.ratio == pytest.approx(1.0, abs=0.05)
    assert np.abs(picture.measured - picture.modelled - picture.residual).max() < 1e-12


@pytest.mark.parametrize(
    "name", ["gear.stiffness", "housing.gain", "stepper.detent.1.phase_deg", "stepper.torque_constant"]
)
def test_the_effect_of_a_knob_is_the_difference_that_a_small_step_makes(session, name):
    at_truth(session).take(name)
    effect = session.effects()["full_46"]
    value = session.state.now.values[name]
    step, words = session.state.knobs[name].step(value)
    assert effect.words == words
    tiny = 1e-4 * step

    def modelled(at):
        session.turn(name, at)
        return session.pictures()["full_46"].modelled

    slope = (modelled(value + tiny) - modelled(value - tiny)) / (2.0 * tiny)
    line = np.polynomial.Polynomial.fit(np.arange(slope.size), slope, 1)
    expected = step * (slope - line(np.arange(slope.size)))
    assert np.linalg.norm(effect.torque - expected) < 1e-3 * np.linalg.norm(expected)
    assert effect.rms == pytest.approx(float(np.sqrt(np.mean(expected**2))), rel=1e-3)


def test_what_a_record_would_tell_alone_is_the_error_of_a_fit_of_one_parameter(session, campaign):
    """Truth: the triangle of the fit's own Jacobian, offset and drift projected out."""
    at_truth(session).set_free("gear.damping", is_free=False)
    session.take("gear.stiffness")
    problem = make_problem(campaign_at(campaign, session.state), 1)
    target = problem.targets[0]
    J = problem.triangle(target, problem.start, (0, target.samples)).jacobian  # to the logarithm
    expected = TRUTH["gear.stiffness"] / np.linalg.norm(J)
    assert session.effects()["full_46"].alone == pytest.approx(expected, rel=1e-3)
