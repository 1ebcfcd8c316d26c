"""Backgrounds that do not go with the runs. Truth: how they were made."""

import pytest

import mechid
from emission_bench import background, record, requirement, samples, write_campaign
from mechid.errors import RecordError

LINES = ((46.0, 0.05), (92.0, 0.02))


def judged(folder, *wanted, lines=LINES, beside=(), seconds=8.0):
    runs = {"run": samples(1, (*lines, *beside)), "off": samples(2, beside, seconds)}
    return mechid.emission(write_campaign(folder, runs, record("run", 46.0), background(), *wanted))


def test_a_background_above_the_mask_leaves_it_undecided(tmp_path):
    """Truth: noise alone reads 0.01 sqrt(2 * 1.5 / 2000) N in a window of 1 s, above a mask of 1e-4 N."""
    found = judged(tmp_path, requirement(mask=((200.0, 1e-4), (500.0, 1e-4))))
    assert found.assessments[0].verdict == "not_decidable"


def test_a_background_of_another_clock_is_refused(tmp_path):
    runs = {"run": samples(1), "off": samples(2)}
    write_campaign(tmp_path, runs, record("run", 46.0), background(fs=1000.0), requirement())
    with pytest.raises(RecordError, match='background "off": sampled at 1000 Hz, record "run" at 2000 Hz; record the'):
        mechid.emission(tmp_path)


def test_a_background_shorter_than_a_window_is_refused(tmp_path):
    with pytest.raises(RecordError, match=r'background "off": lasts 0\.5 s, shorter than a window of 1 s'):
        judged(tmp_path, requirement(), seconds=0.5)


def test_a_background_in_motion_is_refused(tmp_path):
    moving = tuple((46.0 * k, 0.02) for k in (1, 2, 3, 4))
    with pytest.raises(RecordError, match="was recorded in motion: fx has lines at 46, 92, 138, 184 Hz"):
        judged(tmp_path, requirement(), beside=moving, lines=())
