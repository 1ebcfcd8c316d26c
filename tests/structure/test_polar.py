"""Magnitude and phase. Truth: the sum over modes; levels in dB are refused, a phase is read in its own unit."""

import numpy as np
import pytest

import mechid
from mechid.errors import InputFileError
from three_modes import receptance

GRID_HZ = np.arange(1.0, 100.0, 0.05)
H = receptance(GRID_HZ)[:, 1]


def response_csv(folder, columns):
    table = {"frequency_Hz": GRID_HZ, **columns}
    rows = "\n".join(",".join(f"{value:.17g}" for value in row) for row in zip(*table.values(), strict=True))
    (folder / "frf.csv").write_text(f"{','.join(table)}\n{rows}\n", encoding="utf-8")
    return folder / "frf.csv"


def read(folder, **columns):
    return mechid.load_structure(response_csv(folder, columns)).to_line_of_sight(GRID_HZ)[:, 0]


def test_a_level_below_zero_is_named(tmp_path):
    with pytest.raises(InputFileError, match=r"x_mag.*a magnitude is 0 or above; if it is a level in dB, write it as"):
        read(tmp_path, x_mag=20.0 * np.log10(np.abs(H)), x_phase_deg=np.degrees(np.angle(H)))


@pytest.mark.parametrize("name", ["x_mag [dB]", "x_mag [dB re 1 urad/(N m)]", "x_dB", "x_mag_db", "x_mag (dB)"])
def test_a_level_above_zero_is_refused_where_the_header_says_so(tmp_path, name):
    with pytest.raises(InputFileError, match=r"level.* 10\^\(dB/20\)"):
        read(tmp_path, **{name: 20.0 * np.log10(1e12 * np.abs(H)), "x_phase_deg": np.degrees(np.angle(H))})


@pytest.mark.parametrize("reference", [1e-7, 1e-9, 1e-12])
def test_a_level_above_zero_without_a_unit_is_told_by_its_phase(tmp_path, reference):
    """Truth: the same phase and magnitude in a unit are read; no reference makes the level a magnitude."""
    level, phase = 20.0 * np.log10(np.abs(H) / reference), np.degrees(np.angle(H))
    level = level - min(level.min(), 0.0)
    with pytest.raises(InputFileError, match=r"x_mag.*this is a causal response if it is a level in dB"):
        read(tmp_path, x_mag=level, x_phase_deg=phase)
    read(tmp_path, **{"x_mag [rad/(N m)]": level, "x_phase_deg": phase})  # a stated unit is believed


@pytest.mark.parametrize(
    ("name", "phase"),
    [
        ("x_phase_deg", np.degrees(np.angle(H))),
        ("x_phase_deg [deg]", np.degrees(np.angle(H))),
        ("x_phase [deg]", np.degrees(np.unwrap(np.angle(H)))),
        ("x_phase (°)", np.degrees(np.angle(H))),
        ("x_phase_rad", np.angle(H)),
        ("x_phase [rad]", np.unwrap(np.angle(H))),
        ("x_phase_rad [rad]", np.angle(H)),
    ],
)
def test_a_phase_is_read_in_its_unit(tmp_path, name, phase):
    """Truth: the sum over modes."""
    assert read(tmp_path, **{"x_mag": np.abs(H), name: phase}) == pytest.approx(H, rel=1e-9)


def test_a_phase_in_radians_under_degrees_is_asked_about(tmp_path):
    with pytest.raises(InputFileError, match=r"a resonance would turn them further; end the name with _phase \[rad\]"):
        read(tmp_path, x_mag=np.abs(H), x_phase_deg=np.angle(H))


def test_half_a_turn_in_radians_under_degrees_is_asked_about(tmp_path):
    """A free body far above its attitude control: no resonance, and a phase of pi."""
    body = -1.0 / (2.0 * np.pi * GRID_HZ) ** 2
    with pytest.raises(InputFileError, match=r"_phase \[rad\]"):
        read(tmp_path, x_mag=np.abs(body), x_phase_deg=np.full(GRID_HZ.size, np.pi))
    assert read(tmp_path, x_mag=np.abs(body), x_phase_deg=np.full(GRID_HZ.size, 180.0)) == pytest.approx(body, rel=1e-9)


def test_degrees_under_radians_are_asked_about(tmp_path):
    with pytest.raises(InputFileError, match=r"many turns if in radians; end the name with _phase \[deg\]"):
        read(tmp_path, x_mag=np.abs(H), x_phase_rad=np.degrees(np.angle(H)))


def test_a_structure_below_its_first_mode_has_a_small_phase_in_degrees(tmp_path):
    """No false alarm: nothing resonates, the phase is that of the damping alone."""
    body = 1e-6 / (1.0 - (GRID_HZ / 400.0) ** 2 + 0.05j * GRID_HZ / 400.0)
    got = read(tmp_path, x_mag=np.abs(body), x_phase_deg=np.degrees(np.angle(body)))
    assert got == pytest.approx(body, rel=1e-9)


@pytest.mark.parametrize(("name", "found"), [("x_phase", "states no unit"), ("x_phase_deg [rad]", 'has unit "rad"')])
def test_a_phase_without_a_clear_unit_is_asked_about(tmp_path, name, found):
    with pytest.raises(InputFileError, match=rf"{found}; end the name with _phase \[deg\] or _phase \[rad\]"):
        read(tmp_path, **{"x_mag": np.abs(H), name: np.degrees(np.angle(H))})


def test_a_response_has_one_pair(tmp_path):
    angle = np.angle(H)
    with pytest.raises(InputFileError, match="found x_mag, x_phase_deg, x_phase_rad; a response is one pair"):
        read(tmp_path, x_mag=np.abs(H), x_phase_deg=np.degrees(angle), x_phase_rad=angle)
