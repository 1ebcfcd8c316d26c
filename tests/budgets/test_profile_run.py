"""A profile of the rate, against steady rates, definitions in time, and simulations anew."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.budgets.discrepancy import Discrepancy
from mechid.budgets.flying_mechanism import on_modes
from mechid.budgets.indices import Index
from mechid.budgets.levels import constant_member, mixed_level
from mechid.budgets.line_of_sight import respond
from mechid.budgets.operating_mode import OperatingMode
from mechid.budgets.profile_run import ProfileResponse, run_profile
from mechid.budgets.steady_state import steady_state
from mechid.command import Command, RateProfile
from mechid.errors import UsageError
from mechid.structure import Modes, Structure

MODES = Modes(np.array([35.0]), np.array([0.05]), np.array([0.2]), np.array([[0.05]]))
STRUCTURE = Structure(name="s", line_of_sight=("x",), model=MODES)


def mode(points, seconds):
    command = Command(stepping="micro", microsteps=16, rate=RateProfile.through(points))
    return OperatingMode(
        name="m", command=command, rates=np.zeros(0), duration_s=seconds, rms_window_s=0.5, highest_hz=300.0
    )


@pytest.fixture(scope="module")
def course(flying):
    return run_profile(flying.mechanism, mode([(0.0, 20.0), (3.0, 60.0)], 3.0), flying.names, 2, STRUCTURE)


def test_a_profile_of_one_rate_settles_to_the_steady_lines(flying):
    """Truth: the lines of that rate by the modes' transfer function."""
    driven = mode([(0.0, 37.3)], 4.0)
    late = run_profile(flying.mechanism, driven, (), 2, STRUCTURE).windowed_rms()[-1]
    steady = replace(driven, rates=np.array([37.3]), settle_s=2.0)
    lines = respond(steady_state(flying.mechanism, steady, 37.3, (), 2), STRUCTURE)
    np.testing.assert_allclose(late, lines.rms(), rtol=0.01)


def test_derivatives_are_those_of_differences(flying, course):
    """Truth: central differences of half a thousandth of the value, over the whole profile."""
    for name in ("gear.stiffness", "stepper.torque_constant"):
        value = flying.mechanism.value(name)
        step, driven = 5e-4 * value, mode([(0.0, 20.0), (3.0, 60.0)], 3.0)
        ends = [
            run_profile(flying.mechanism.with_values({name: value + s}), driven, (), 2, STRUCTURE).series
            for s in (step, -step)
        ]
        expected = (ends[0] - ends[1]) / (2.0 * step)
        got = course.slopes[flying.names.index(name)]
        assert np.sqrt(np.mean((got - expected) ** 2)) < 0.02 * expected.std()


def test_windowed_draws_are_those_of_the_moved_series(course):
    """Truth: the windows of the series moved by hand."""
    by = np.random.default_rng(3).normal(size=(2, course.columns)) * 1e-3
    for row, got in zip(by, course.windowed_draws(by), strict=True):
        moved = replace(course, series=course.series + np.tensordot(row, course.slopes, axes=1))
        np.testing.assert_allclose(got, moved.windowed_rms(), rtol=1e-9)


@pytest.mark.parametrize(
    "index", [Index("APE"), Index("MPE", 0.3), Index("RPE", 0.3), Index("PDE", 0.3, 0.7)], ids=lambda i: i.kind
)
def test_levels_are_those_of_the_definitions_over_all_instants(index):
    """Truth: 3.2 of the standard over every window (and instant) of a chirp with a drift."""
    rate = 200.0
    t = np.arange(4000) / rate
    e = np.sin(2.0 * np.pi * 0.1 * t**2) * (1.0 + 0.1 * t) + 0.05 * t
    made = ProfileResponse(("x",), e, rate, e[:, None], np.zeros((0, e.size, 1)), 1, 1.0)
    n, apart = max(1, round(index.window_s * rate)), round(index.separation_s * rate)
    windows = np.lib.stride_tricks.sliding_window_view(e, n)
    mean = windows.mean(axis=1)
    values = {
        "APE": lambda: e,
        "MPE": lambda: mean,
        "RPE": (windows - mean[:, None]).ravel,
        "PDE": lambda: mean[apart:] - mean[:-apart],
    }[index.kind]()
    error = made.error_under(index)(np.zeros(0))
    for confidence in (0.5, 0.95):
        got = mixed_level([constant_member(error)], index, confidence, 0)
        assert got == pytest.approx(np.quantile(np.abs(values), confidence), rel=0.01)


def test_a_profile_shorter_than_the_windows_is_refused(course):
    with pytest.raises(UsageError, match="PDE needs 5 s, the profile takes 3"):
        course.error_under(Index("PDE", 1.0, 4.0))


def test_what_the_model_misses_scales_the_course(course):
    """Truth: a tenth of it, one standard deviation, over 400 draws."""
    rng = np.random.default_rng(5)
    factors = [course.draw_discrepancy(Discrepancy(0.1), rng).series[-1, 0] / course.series[-1, 0] for _ in range(400)]
    assert np.std(factors) == pytest.approx(0.1, rel=0.1)
    assert np.mean(factors) == pytest.approx(1.0, abs=0.015)


@pytest.mark.slow
def test_two_way_through_a_profile(flying, course):
    """Truth: modes that hardly move leave the torque as it is; at |R K| = 0.06 it moves by a few percent."""
    driven = mode([(0.0, 20.0), (3.0, 60.0)], 3.0)

    def joined(shape):
        modes = replace(MODES, interface=np.array([shape]))
        structure = replace(STRUCTURE, model=modes)
        return run_profile(on_modes(flying.mechanism, modes), driven, (), 2, structure).torque

    still = joined(1e-4)
    size = course.torque.std()
    assert np.sqrt(np.mean((still - course.torque) ** 2)) < 1e-4 * size
    assert 1e-3 * size < np.sqrt(np.mean((joined(0.5) - course.torque) ** 2)) < 0.2 * size
