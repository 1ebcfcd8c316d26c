"""Tables and their changes. Truth: sines typed by hand, and the symmetries that each basis promises."""

import numpy as np
import pytest

from mechid.command.phase_table import nominal_table
from mechid.quiet_drives.table_basis import (
    fundamental,
    quarter_wave_harmonics,
    roughness,
    table_entries,
    table_harmonics,
)


def test_the_nominal_table_is_the_sine_of_the_command():
    angle = np.deg2rad(22.5 * np.arange(16))
    np.testing.assert_allclose(nominal_table(4), np.column_stack([-np.cos(angle), np.sin(angle)]), atol=1e-15)


@pytest.mark.parametrize("changes", [table_harmonics(4, 23, mirrored=True), table_entries(4, mirrored=True)])
def test_a_mirrored_change_turns_its_sign_in_half_a_period_and_all_such_changes_are_reached(changes):
    np.testing.assert_allclose(changes[:, 8:], -changes[:, :8], atol=1e-12)
    assert np.linalg.matrix_rank(changes.reshape(len(changes), -1)) == 16


def test_changes_without_a_mirror_reach_every_table():
    assert np.linalg.matrix_rank(table_harmonics(4, 23, mirrored=False).reshape(-1, 32)) == 32


def test_a_quarter_wave_serves_both_phases():
    for change in quarter_wave_harmonics(4, 7):
        wave = change[:, 1]
        np.testing.assert_allclose(change[:, 0], -np.roll(wave, -4), atol=1e-12)
        np.testing.assert_allclose(wave[:9], wave[8::-1], atol=1e-12)


def test_the_roughness_of_a_harmonic_grows_with_its_square():
    """Truth: the second derivative of cos(k theta) is -k^2 cos, of RMS k^2 / sqrt(2), here of one of two phases."""
    angle = 2.0 * np.pi * np.arange(256) / 256
    change = np.zeros((1, 256, 2))
    change[0, :, 0] = np.cos(3.0 * angle)
    assert np.linalg.norm(roughness(change)) == pytest.approx(9.0 / 2.0, rel=1e-3)


def test_only_the_first_harmonic_in_its_phase_turns_with_the_nominal_table():
    changes = np.array([nominal_table(8), np.roll(nominal_table(8), 8, axis=0), nominal_table(8)[::-1]])
    np.testing.assert_allclose(fundamental(changes)[:2], [1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(fundamental(table_harmonics(8, 9, mirrored=True)[4:]), 0.0, atol=1e-12)
