"""A sweep over time and frequency. Truth: chirps of known order and amplitude, the twin's noise, closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest

import synthetic
from mechid.web import sweep as module
from mechid.web.session import Session
from mechid.web.sweep import sweep_picture
from turned import TRUTH

AMPLITUDE = 0.05


@pytest.fixture
def session(source):
    made = Session(source)
    made.look(("full_46", "sweep"), 1e9)
    return made


def chirp(scene, picture, order):
    """Return a sine at an order of the step rate, (n,)."""
    t = scene.base.truncate(picture.measured.size).times
    start, end = scene.rate[0], scene.rate[-1]
    slope = (end[1] - start[1]) / (end[0] - start[0])
    return AMPLITUDE * np.sin(2.0 * math.pi * order * (start[1] * t + 0.5 * slope * t**2))


def strongest(image, column):
    """Return frequency and amplitude of the largest row of a column."""
    row = int(np.argmax(image.measured[:, column]))
    return image.lowest_hz + (row + 0.5) * image.row_hz, image.measured[row, column]


def test_only_records_whose_rate_varies_have_one(session):
    assert list(session.sweeps(session.pictures())) == ["sweep"]


@pytest.mark.parametrize("order", [1.0, 2.0])
def test_a_line_of_an_order_stands_on_its_mark(session, order):
    """Within a bin, and with the sine's own amplitude as far as the rate stands still within a window."""
    scene, picture = session.scenes["sweep"], session.pictures()["sweep"]
    image = sweep_picture(scene, replace(picture, measured=chirp(scene, picture, order)), session.mechanism)
    inside = range(image.time_s.size // 10, 9 * image.time_s.size // 10, 10)
    for column in inside:
        expected = order * np.interp(image.time_s[column], *scene.rate.T)
        hz, amplitude = strongest(image, column)
        assert abs(hz - expected) <= image.row_hz
        assert amplitude == pytest.approx(AMPLITUDE, rel=0.25)


def test_what_is_left_at_the_truth_is_the_noise(session):
    """Truth: a window of n samples leaves white noise an amplitude of sigma sqrt(6 / n) RMS, Hann's noise width 1.5."""
    for name, value in TRUTH.items():
        session.turn(name, value)
    image = session.sweeps(session.pictures())["sweep"]
    window = round(1.0 / image.row_hz * synthetic.RATE_HZ)
    expected = synthetic.NOISE_NM * math.sqrt(6.0 / window)
    middle = slice(image.time_s.size // 10, -image.time_s.size // 10)
    assert np.sqrt(np.mean(image.residual[3:, middle] ** 2)) == pytest.approx(expected, rel=0.1)
    assert np.abs(image.measured - image.modelled).max() < 10.0 * expected


def test_orders_and_resonances_are_those_of_the_command_and_of_what_is_set(session):
    session.turn("gear.stiffness", 1500.0)
    image = session.sweeps(session.pictures())["sweep"]
    assert image.orders == (0.5, 1.0, 2.0, 3.0, 4.0, 16.0)
    load, housing = image.resonances
    assert load.frequency_hz == pytest.approx(math.sqrt(1500.0 / 0.010534) / (2.0 * math.pi))
    assert image.rate.tolist() == [[0.0, 20.0], [0.8, 100.0]]
    assert image.tops_hz == (250.0, 1100.0)
    assert image.tops_hz[0] < housing.frequency_hz < image.tops_hz[1]


def test_many_bins_are_drawn_by_the_largest_of_each_few(session, monkeypatch):
    pictures = session.pictures()
    every = session.sweeps(pictures)["sweep"]
    monkeypatch.setattr(module, "MOST_ROWS", 20)
    few = session.sweeps(pictures)["sweep"]
    assert len(few.measured) <= 20 < len(every.measured)
    assert np.array_equal(few.measured.max(axis=0), every.measured.max(axis=0))
    each = round(few.row_hz / every.row_hz)
    assert np.array_equal(few.residual[1], every.residual[each : 2 * each].max(axis=0))


def test_where_the_model_cannot_be_simulated_its_image_is_empty_and_the_record_stays(session):
    picture = session.pictures()["sweep"]
    lost = replace(picture, modelled=np.full_like(picture.modelled, np.nan))
    image = sweep_picture(session.scenes["sweep"], lost, session.mechanism)
    assert np.isnan(image.modelled).all()
    assert np.isfinite(image.measured).all()
