"""A record cut into parts. Truth: products of the columns by hand; however a record is cut, its parts sum to it."""

import numpy as np
import pytest

from mechid.command import Timing
from mechid.identification.output_error.target import target_of
from mechid.identification.uncertainty.parts import Parts, PartsAccumulator
from mechid.identification.uncertainty.settings import ERRORS
from synthetic import COMMANDS, RATE_HZ, record

SAMPLES, WIDTH = 4000, 5
"""Columns: offset, drift, the residual, two derivatives."""


@pytest.fixture(scope="module")
def cut():
    """Return a target, columns of it, and its parts of them, added in blocks of odd lengths."""
    rng = np.random.default_rng(11)
    rows = rng.standard_normal((WIDTH, SAMPLES))
    rows[0], rows[1] = 1.0, np.linspace(-1.0, 1.0, SAMPLES)
    target = target_of(record("full_46", rng.standard_normal(SAMPLES), COMMANDS["full_46"]))
    parts = PartsAccumulator(target, Timing(), (0, SAMPLES), [WIDTH], whitened=True)
    for block in np.split(rows, [700, 1901, 3333], axis=1):
        parts.add(0, block)
    return target, rows, parts


def test_parts_by_phase_and_over_time_sum_to_the_whole(cut):
    """Truth: residual and derivatives less offset and drift by least squares, in sigmas."""
    target, rows, parts = cut
    rest = rows[2:] - np.linalg.lstsq(rows[:2].T, rows[2:].T, rcond=None)[0].T @ rows[:2]
    rest /= target.leading.sigma
    found = parts.sum_parts(parts.projections)
    for some in (found.phases, found.stretches):
        np.testing.assert_allclose(some.scores.sum(axis=0), rest[1:] @ rest[0], rtol=1e-8)
        np.testing.assert_allclose(some.information.sum(axis=0), rest[1:] @ rest[1:].T, rtol=1e-8)


def test_a_stretch_is_about_a_tenth_of_a_second_and_all_are_four_quarters(cut):
    found = cut[2].sum_parts(cut[2].projections)
    assert found.stretches.size == round(SAMPLES / RATE_HZ / ERRORS.stretch_s) // ERRORS.quarters * ERRORS.quarters
    assert found.stretches.merge(ERRORS.quarters).size == ERRORS.quarters


def test_neighbours_are_joined_and_parts_that_no_sample_moves_are_left_out():
    scores = np.arange(8.0).reshape(4, 2)
    information = np.array([np.eye(2), np.zeros((2, 2)), np.eye(2), np.eye(2)])
    parts = Parts(scores, information)
    np.testing.assert_array_equal(parts.merge(2).scores, [[2.0, 4.0], [10.0, 12.0]])
    np.testing.assert_array_equal(parts.merge(2).information, [np.eye(2), 2.0 * np.eye(2)])
    np.testing.assert_array_equal(parts.informative.scores, scores[[0, 2, 3]])
