"""Hum in first windows. Truth: the sine that was laid over synthetic records, and their noise."""

from dataclasses import replace

import numpy as np
import pytest

from mechid.identification.identify import make_problem
from mechid.identification.search.first_moments import first_residual, first_window
from mechid.identification.search.multistart import robust_triangle
from mechid.identification.search.rest import hum_from_rest, rest_window
from synthetic import COMMANDS, NOISE_NM, RATE_HZ, campaign, measured, record, truth

HUM_NM, HUM_HZ = 2.0 * NOISE_NM, 50.02


def hummed(start_s, hum_nm=HUM_NM):
    """Return the problem of one record whose command begins late, under hum that is projected out."""
    command = COMMANDS["full_46"]
    y = measured(truth(), command, np.random.default_rng(3), seconds=start_s + 0.3, time_offset_s=start_s)
    y += hum_nm * np.sin(2.0 * np.pi * HUM_HZ * np.arange(y.size) / RATE_HZ + 1.0)
    made = record("full_46", y, command)
    made = replace(made, parameters=(replace(made.parameters[0], value=start_s),))
    made = replace(made, matches=(replace(made.matches[0], lines_hz=(HUM_HZ,)),))
    return make_problem(campaign(truth(), made), 1)


def test_hum_goes_on_as_the_rest_shows_it():
    target = hummed(0.5).targets[0]
    first, stop = first_window(target)
    found = hum_from_rest(target.leading, rest_window(target), (first, stop))
    true = HUM_NM * np.sin(2.0 * np.pi * HUM_HZ * np.arange(first, stop) / RATE_HZ + 1.0)
    np.testing.assert_allclose(found, true, atol=0.15 * NOISE_NM)


def test_the_truth_leaves_its_noise_alone():
    """Truth: one noise variance a sample, where hum of twice the noise would leave three."""
    problem = hummed(0.5)
    (target,) = problem.targets
    assert np.mean(first_residual(problem, target, problem.start) ** 2) == pytest.approx(1.0, abs=0.2)
    triangle = robust_triangle(problem, problem.start)
    assert triangle.cost / triangle.samples == pytest.approx(1.0, abs=0.2)


def test_a_record_without_rest_keeps_its_hum():
    target = hummed(0.0).targets[0]
    assert not hum_from_rest(target.leading, rest_window(target), first_window(target)).any()


def test_a_channel_without_lines_has_none():
    target = hummed(0.5, 0.0).targets[0]
    plain = replace(target.leading, turns=())
    assert not hum_from_rest(plain, rest_window(target), first_window(target)).any()


def test_without_rest_the_waves_of_hum_leave_nothing_of_it():
    """Truth: the same records without hum, whose residual and its slopes lose the same waves."""
    with_hum, without = hummed(0.0), hummed(0.0, 0.0)
    q = with_hum.coordinates.clip(1.02 * with_hum.start)
    one, other = (first_residual(problem, problem.targets[0], q) for problem in (with_hum, without))
    np.testing.assert_allclose(one - one.mean(), other - other.mean(), atol=1e-8)
    assert np.mean(first_residual(with_hum, with_hum.targets[0], with_hum.start) ** 2) == pytest.approx(1.0, abs=0.2)
    slopes = [robust_triangle(problem, q) for problem in (with_hum, without)]
    np.testing.assert_allclose(slopes[0].jacobian[0], slopes[1].jacobian[0], rtol=1e-3)
