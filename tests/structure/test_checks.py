"""Checks of transfer functions, each against a response built to fail it or to pass."""

import numpy as np
import pytest

from mechid.structure.checks import energy_before_impulse, passivity_finding, response_findings
from three_modes import receptance

F = np.arange(1.0, 400.0, 0.1)


def findings(values, f=F):
    return list(response_findings(f, values, ("x", "y")))


def test_a_good_response_is_told_only_that_it_is_free():
    """Truth: a sum over damped modes is passive and causal; one of its modes is a rigid body, beyond x's 1/f^2."""
    assert all("1/f^2" in line for line in findings(receptance(F)))
    assert findings(receptance(F)) != []


def test_the_wrong_sign_of_phase_is_told():
    """Truth: the complex conjugate is the response reversed in time, and gives out power at the driving point."""
    told = " ".join(findings(receptance(F).conj()))
    assert "is not passive" in told
    assert "most at 18 Hz" in told
    assert "the phase has the opposite sign" in told


@pytest.mark.parametrize(("advance_s", "low", "high"), [(-0.02, 0.0, 0.01), (0.3, 0.3, 1.0)])
def test_an_advance_is_not_causal_and_a_delay_is(advance_s, low, high):
    """Truth: h(t + advance) has as much energy before 0 as h has in [0, advance]."""
    h = receptance(F)[:, 1] * np.exp(2j * np.pi * F * advance_s)
    assert low <= energy_before_impulse(F, h) <= high


def test_energy_before_in_closed_form():
    """Truth: exp(-a t) advanced by T has the share 1 - exp(-2 a T) before 0; here half."""
    a, f0 = 3.0, 100.0
    w = 2.0 * np.pi * F
    rate = 1.0 / ((2.0 * np.pi * f0) ** 2 + a**2 - w**2 + 2j * a * w)  # of the accelerance, which is what is judged
    advance = np.log(2.0) / (2.0 * a)
    assert abs(energy_before_impulse(F, -rate / w**2 * np.exp(1j * w * advance)) - 0.5) < 0.005


def test_a_resonance_between_points_is_told():
    coarse = np.arange(1.0, 100.0, 1.0)
    assert any("18 Hz has one point above half its height" in line for line in findings(receptance(coarse), coarse))


def test_two_ends_are_no_driving_point():
    """Truth: torque and rotation of opposite sense give a negative receptance, which is active throughout."""
    (line,) = passivity_finding(F, -receptance(F)[:, 0], 1e-9)
    assert "same point, axis and sense" in line
