"""Modes against closed forms."""

import numpy as np
from scipy.linalg import expm

from mechid.structure import Modes
from three_modes import DAMPING, FREQUENCY_HZ, INTERFACE, LINE_OF_SIGHT


def single(frequency_hz=20.0, damping=0.02, phi=0.3, psi=0.1):
    return Modes(*(np.array([v]) for v in (frequency_hz, damping, phi)), np.array([[psi]]))


def test_a_single_mode_at_resonance_and_at_rest():
    """Truth: phi psi / w0^2 at rest, a quarter turn behind and 1/(2 zeta) of it at resonance."""
    static = 0.3 * 0.1 / (2.0 * np.pi * 20.0) ** 2
    h = single().response(np.array([0.0, 20.0]))[:, 1]
    np.testing.assert_allclose(h, [static, -1j * static / 0.04], rtol=1e-12)


def test_a_free_body_is_an_inertia():
    """Truth: Newton, -1/(J w^2) with phi = 1/sqrt(J); at 0 Hz it is not known."""
    J = 250.0
    body = single(0.0, 0.0, J**-0.5, J**-0.5)
    f = np.array([0.0, 0.1, 3.0])
    h = body.response(f)[:, 0]
    assert np.isnan(h[0])
    np.testing.assert_allclose(h[1:], -1.0 / (J * (2.0 * np.pi * f[1:]) ** 2), rtol=1e-12)


def test_attitude_control_holds_a_free_body_below_its_bandwidth():
    """Truth: 1/(J wc^2) for slow torques, the free body's above."""
    J, wc = 250.0, 2.0 * np.pi * 0.05
    held = single(0.0, 0.0, J**-0.5, J**-0.5).with_attitude_control(0.05, 0.7)
    np.testing.assert_allclose(held.response(np.array([0.0]))[0, 0], 1.0 / (J * wc**2), rtol=1e-12)
    np.testing.assert_allclose(held.response(np.array([50.0]))[0, 0], -1.0 / (J * (100.0 * np.pi) ** 2), rtol=2e-3)


def test_the_state_space_rings_as_the_modes_do(modes):
    """Truth: the impulse response in closed form, phi psi t for the free body and damped sines for the others."""
    A, B, C = modes.state_space()
    t = np.linspace(0.0, 0.2, 50)
    got = np.array([C @ expm(A * instant) @ B for instant in t])[:, :, 0]
    shapes = np.vstack([INTERFACE, LINE_OF_SIGHT])
    expected = np.outer(t, shapes[:, 0] * INTERFACE[0])
    for k in (1, 2):
        w, zeta = 2.0 * np.pi * FREQUENCY_HZ[k], DAMPING[k]
        w_d = w * np.sqrt(1.0 - zeta**2)
        expected += np.outer(np.exp(-zeta * w * t) * np.sin(w_d * t) / w_d, shapes[:, k] * INTERFACE[k])
    np.testing.assert_allclose(got, expected, atol=1e-12)
