"""What is said of a bench. Truth: the resonance that was put into its background, and the entries of [bench]."""

import math

import numpy as np
import pytest
from scipy.signal import lfilter

import mechid
from emission_bench import FS, background, record, requirement, samples, write_campaign
from mechid.emissions.trust import from_resonance, lowest_resonance

MODES = '[{ direction = "fx", frequency_hz = 300.0, damping = 0.02 }]'


def coloured(frequency, seed=2, seconds=8.0):
    """Return white noise in six channels with a resonance of 3 % damping in it."""
    white = samples(seed, seconds=seconds)
    pole = np.exp(2.0 * np.pi * frequency / FS * (-0.03 + 1j))
    return white + 0.2 * lfilter([1.0 - abs(pole)], [1.0, -2.0 * pole.real, abs(pole) ** 2], 10.0 * white, axis=0)


def found(folder, declared="", off=None):
    runs = {"run": samples(1, ((46.0, 0.05), (322.0, 0.05))), "off": samples(2) if off is None else off}
    wanted = requirement(mask=((20.0, 0.2), (500.0, 0.2)))
    write_campaign(folder, runs, record("run", 46.0), background(), wanted)
    text = (folder / "campaign.toml").read_text()
    (folder / "campaign.toml").write_text(text.replace("[0.0, 0.0, 0.0]\n", f"[0.0, 0.0, 0.0]\n{declared}\n", 1))
    return mechid.emission(folder)


def test_a_resonance_in_the_background_says_how_far_a_record_is_trusted(tmp_path):
    result = found(tmp_path, off=coloured(400.0))
    assert result.bench.trusted_hz == pytest.approx(400.0 / 3.0, rel=0.03)
    assert "shows a resonance at" in result.bench.reason
    assert any(note.startswith("Decided above 13") for note in result.notes)


def test_a_background_without_one_proves_nothing(tmp_path):
    result = found(tmp_path)
    assert math.isnan(result.bench.trusted_hz)
    assert "shows no resonance up to 1000 Hz, which proves none" in result.bench.reason
    assert any("No calibration matrix is declared" in note for note in result.notes)


def test_a_declared_band_is_believed(tmp_path):
    result = found(tmp_path, "usable_band_hz = [5.0, 350.0]")
    assert result.bench.trusted_hz == 350.0
    assert "usable_band_hz trusts it up to 350 Hz" in result.bench.reason


def test_a_correction_says_where_it_ends_and_why(tmp_path):
    result = found(tmp_path, f"table_response = {{ modes = {MODES}, uncertainty_percent = 1.0 }}")
    # 4 r^2 / (1 - r^2) of 1 % is 1 dB at 0.868 of the mode
    assert result.bench.bands_hz["fx"][1] == pytest.approx(0.868 * 300.0, rel=0.01)
    assert any("1 mode, is corrected up to: fx 26" in note and "(95 %) exceeds 1 dB" in note for note in result.notes)


def test_without_a_background_none_is_said_to_show_nothing():
    assert lowest_resonance({"fx": None}) is None
    _, reason = from_resonance(None, 2000.0, is_measured=False)
    assert "no background was measured that could show its resonances" in reason
    assert "shows no resonance" not in reason
