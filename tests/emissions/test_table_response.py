"""Responses of tables. Truth: one-degree-of-freedom systems, by hand."""

import numpy as np
import pytest

from mechid.campaign.table_response_entry import TableMode
from mechid.emissions.table_response import MeasuredTable, ModalTable


def modal(*modes, uncertainty=0.01, damping_uncertainty=0.3):
    made = [TableMode(component=c, frequency_hz=f, damping=z, share=s) for c, f, z, s in modes]
    return ModalTable(modes=made, uncertainty=uncertainty, damping_uncertainty=damping_uncertainty)


def oscillator(f, f0, zeta):
    return 1.0 / (1.0 - (f / f0) ** 2 + 2j * zeta * f / f0)


F = np.array([0.0, 300.0, 900.0, 1000.0])


def test_modes_of_a_component_add_up_by_their_shares():
    found = modal((0, 900.0, 0.02, 0.7), (0, 1200.0, 0.05, 0.3), (5, 1000.0, 0.01, 1.0)).at(F)
    np.testing.assert_allclose(found[:, 0, 0], 0.7 * oscillator(F, 900, 0.02) + 0.3 * oscillator(F, 1200, 0.05))
    np.testing.assert_allclose(found[:, 5, 5], oscillator(F, 1000, 0.01))
    np.testing.assert_allclose(found[:, 1, 1], 1.0)
    assert not found[:, 0, 1].any()


def test_a_component_without_a_mode_is_known_to_a_third_of_the_highest_one():
    coverage = modal((0, 900.0, 0.02, 1.0), (5, 1200.0, 0.02, 1.0)).coverage_hz
    assert coverage[1] == pytest.approx([0.0, 400.0])
    assert coverage[0, 1] > 1200.0


def test_the_error_of_a_frequency_is_that_of_two_magnitudes():
    """Truth: the difference of two oscillators 0.002 % apart, for a standard error of 1 %."""
    found = modal((0, 900.0, 0.02, 1.0), damping_uncertainty=0.0).sigma(F)[:, 0, 0]
    high, low = (np.abs(oscillator(F, 900.0 * (1.0 + off), 0.02)) for off in (1e-5, -1e-5))
    np.testing.assert_allclose(found, 500.0 * np.abs(high - low), rtol=1e-4, atol=1e-9)


def test_the_error_of_a_damping_likewise():
    found = modal((0, 900.0, 0.02, 1.0), uncertainty=1e-12).sigma(F)[:, 0, 0]
    high, low = (np.abs(oscillator(F, 900.0, 0.02 * (1.0 + off))) for off in (1e-5, -1e-5))
    np.testing.assert_allclose(found, 0.3 * np.abs(high - low) / 2e-5, rtol=1e-4, atol=1e-9)


def measured(noise=0.0, step=2.0):
    f = np.arange(10.0, 800.0, step)
    rng = np.random.default_rng(4)
    values = np.tile(np.eye(6, dtype=complex), (f.size, 1, 1))
    random = rng.normal(size=(2, f.size)) * noise
    values[:, 2, 2] = oscillator(f, 1000.0, 0.02) * (1.0 + random[0] + 1j * random[1])
    return MeasuredTable(frequency_hz=f, values=values, measured=(2,), uncertainty=0.01)


def test_a_measured_response_is_interpolated_and_real_at_rest():
    found = measured().at(np.array([0.0, 5.0, 11.0, 500.0, 900.0]))[:, 2, 2]
    assert found[0].imag == 0.0
    assert found[2] == pytest.approx(oscillator(11.0, 1000, 0.02), rel=1e-5)
    assert found[3] == pytest.approx(oscillator(500.0, 1000, 0.02), rel=1e-5)
    assert found[4] == pytest.approx(oscillator(798.0, 1000, 0.02), rel=1e-9)  # held beyond its end


def test_its_coverage_is_its_own():
    coverage = measured().coverage_hz
    assert coverage[2].tolist() == [10.0, 798.0]
    assert np.isnan(coverage[0]).all()


@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_its_error_holds_the_stated_one_and_the_noise_of_its_points(noise):
    """Truth: 1 % stated, and the noise that was added, both parts."""
    found = measured(noise).sigma(np.array([300.0]))[0, 2, 2] / abs(oscillator(300.0, 1000, 0.02))
    assert found == pytest.approx(np.hypot(0.01, np.sqrt(2.0) * noise), rel=0.4 if noise else 1e-3)
