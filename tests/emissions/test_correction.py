"""Correction of a table. Truth: the loads that a table, by its transfer functions, made the records of."""

import numpy as np
import pytest

from mechid.campaign.table_response_entry import TableMode
from mechid.emissions.correction import Correction
from mechid.emissions.table_response import MeasuredTable, ModalTable

FS, N = 4000.0, 16_000
TIME = np.arange(N) / FS
SCALE = np.array([1.0, 1.0, 1.0, 0.1, 0.1, 0.1])


def table(uncertainty=0.005, zeta=0.02):
    modes = [TableMode(component=k, frequency_hz=900.0 + 80.0 * k, damping=zeta, share=1.0) for k in range(6)]
    return ModalTable(modes=modes, uncertainty=uncertainty, damping_uncertainty=0.2)


def sine(amplitude, f, phase):
    return amplitude * np.cos(2.0 * np.pi * f * TIME + phase)


@pytest.mark.parametrize("f", [20.0, 300.0, 630.0])
def test_a_sine_comes_back_to_both_ends_of_a_record(f):
    h = table().at(np.array([f]))[0, 0, 0]
    measured = 5.0 + sine(abs(h), f, 0.3 + np.angle(h))
    found = Correction(response=table()).filter_loads({0: measured}, FS)[0]
    assert np.abs(found - 5.0 - sine(1.0, f, 0.3)).max() < 0.005


def test_all_pairs_of_a_measured_response_are_inverted():
    """Truth: six loads through 3 % of cross-talk and six modes."""
    rng = np.random.default_rng(0)
    cross = (np.eye(6) + 0.03 * rng.choice([-1.0, 1.0], (6, 6))) * SCALE[:, None] / SCALE[None, :]
    grid = np.arange(0.0, 1500.0, 2.0)
    seen = MeasuredTable(
        frequency_hz=grid, values=cross @ table().at(grid), measured=tuple(range(6)), uncertainty=0.005
    )
    f = 400.0
    h = cross @ table().at(np.array([f]))[0]
    loads = SCALE * (1.0 + rng.random(6))
    passed = h @ (loads * np.exp(1j * np.arange(6.0)))
    found = Correction(response=seen).filter_loads({k: sine(abs(c), f, np.angle(c)) for k, c in enumerate(passed)}, FS)
    for k, load in enumerate(loads.tolist()):
        assert np.abs(found[k] - sine(load, f, float(k)))[200:-200].max() < 0.005 * load


def test_a_component_that_is_coupled_to_none_is_corrected_alone():
    assert np.array_equal(Correction(response=table()).coupled, np.eye(6, dtype=bool))


def test_the_inverse_is_bounded_where_a_response_vanishes():
    values = np.tile(np.eye(6, dtype=complex), (100, 1, 1))
    values[50, 0, 0] = 0.0
    seen = MeasuredTable(frequency_hz=np.arange(100.0), values=values, measured=(0,), uncertainty=0.01)
    grid = np.linspace(49.0, 51.0, 1001)
    assert 24.0 < np.abs(Correction(response=seen).inverse(grid)[:, 0, 0]).max() <= 25.0 + 1e-9


@pytest.mark.parametrize("uncertainty", [0.003, 0.01, 0.03])
def test_the_band_ends_where_the_uncertainty_is_a_decibel(uncertainty):
    """Truth: 1 - r^2 of a frequency that is 2 standard errors off, over that of the right one, is 1 dB."""
    made = Correction(response=table(uncertainty, zeta=1e-4))
    for k, (low, high) in enumerate(made.supported_hz.tolist()):
        r = high / (900.0 + 80.0 * k)
        slope = 2.0 * r**2 / (1.0 - r**2) * uncertainty
        assert low == 0.0
        assert 2.0 * slope == pytest.approx(10.0 ** (1.0 / 20.0) - 1.0, rel=0.05)


def test_the_errors_are_the_scatter_of_corrected_loads():
    """Truth: responses drawn with their errors, inverted as they are, 400 times."""
    rng, f = np.random.default_rng(1), np.array([500.0])
    true = table()
    ratios = []
    for _ in range(400):
        off = ModalTable(
            modes=[TableMode(component=0, frequency_hz=900.0 * (1 + 0.005 * rng.normal()), damping=0.02, share=1.0)],
            uncertainty=0.005,
            damping_uncertainty=0.0,
        )
        ratios.append(abs(Correction(response=off).inverse(f)[0, 0, 0] * true.at(f)[0, 0, 0]))
    assert np.sqrt(Correction(response=true).error_variance(f, 0)[0, 0]) == pytest.approx(np.std(ratios), rel=0.15)


def test_a_calibration_alone_leaves_its_error_in_each_load_from_each():
    made = Correction(response=None, calibration_error=0.01)
    found = made.error_variance(np.array([10.0, 500.0]), 3)
    # the moment of 0.1 m for each newton
    assert found[0] == pytest.approx(1e-4 * np.array([0.01, 0.01, 0.01, 1.0, 1.0, 1.0]))
    assert made.supported_hz.tolist() == [[0.0, np.inf]] * 6


def test_a_declared_band_narrows_the_supported_one():
    made = Correction(response=table(), band_hz=(5.0, 500.0))
    assert made.applied_hz.tolist() == [[5.0, 500.0]] * 6
    assert made.supported_hz[0, 1] > 700.0


def test_a_record_shorter_than_the_filter():
    h = table().at(np.array([200.0]))[0, 0, 0]
    found = Correction(response=table()).filter_loads({0: sine(abs(h), 200.0, np.angle(h))[:300]}, FS)[0]
    assert np.abs(found - sine(1.0, 200.0, 0.0)[:300]).max() < 0.01
