"""Parametric bootstrap: the Fisher sigma where the problem is nearly linear, colour, tallies, and going on."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from finished import optimum
from mechid.identification.computation.journal import Journal
from mechid.identification.refit import bootstrap as module
from mechid.identification.refit import chord
from mechid.identification.refit.bootstrap import DrawOutcome, bootstrap
from mechid.identification.refit.settings import REFIT
from mechid.signal.autoregression import Autoregression
from synthetic import measuring

HOUSING = ("housing.gain", "housing.frequency", "housing.damping")
DRAWS = 80


@pytest.fixture(scope="module")
def housing():
    return optimum(*HOUSING)


@pytest.fixture(scope="module")
def found(housing):
    return bootstrap(housing, DRAWS, workers=2)


def test_the_scatter_of_a_nearly_linear_problem_is_the_fisher_sigma(housing, found):
    """Truth: (J^T J)^-1 for white noise; the sample variance of 80 within its own 99.9 % interval."""
    low, high = np.sqrt(chi2.ppf([0.0005, 0.9995], DRAWS - 1) / (DRAWS - 1))
    for spread in found.spreads:
        sigma = housing.parameters[spread.name].std_error_white
        assert low < spread.deviation / sigma < high, spread.name
        assert abs(spread.mean_shift) < 3.5 * sigma / math.sqrt(DRAWS), spread.name
    assert found.tally[DrawOutcome.CONVERGED] == DRAWS


def test_the_interval_is_that_of_the_draws(found):
    """Truth: NumPy's quantiles of the values of all draws."""
    for spread in found.spreads:
        values = [d.values[spread.name] for d in found.draws]
        np.testing.assert_allclose(spread.interval, np.quantile(values, [0.025, 0.975]), rtol=1e-12)


def test_numbers_are_the_same_whatever_the_number_of_workers(housing, found):
    assert repr(bootstrap(housing, 6, workers=1).draws) == repr(found.draws[:6])


def test_a_resumed_bootstrap_is_the_same_and_may_grow(housing, found, tmp_path):
    """Truth: the undisturbed run; of its journal eight draws and the beginning of eight more are left."""
    path = tmp_path / "bootstrap.jsonl"
    bootstrap(housing, 17, workers=2, journal=Journal.open(path, {}))
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:2]) + lines[2][:40])
    again = bootstrap(housing, 19, journal=Journal.open(path, {}, resume=True))
    assert repr(again.draws) == repr(found.draws[:19])


def test_coloured_noise_is_drawn_with_its_colour(housing):
    """Truth: the process' own variance and lag-one correlation, b = (1, -0.9): 1 / (1 - 0.81) and 0.9."""
    colour = Autoregression(np.array([1.0, -0.9]), 0.002)
    world = replace(module._build_basis(housing), noise={"full_46": (colour,)})
    target = measuring(housing.problem.targets[0], np.zeros(0))
    rng = np.random.default_rng(8)
    draws = [module._draw_target(target, world, rng).leading.measured - world.signals["full_46"][0] for _ in range(40)]
    series = np.array(draws)
    assert series.std() == pytest.approx(0.002 / math.sqrt(0.19), rel=0.03)
    assert np.mean(series[:, 1:] * series[:, :-1]) / series.var() == pytest.approx(0.9, abs=0.01)


def test_what_ends_elsewhere_is_tallied_and_kept(housing, monkeypatch):
    """Truth: with every distance called too far all draws are elsewhere, and still in the quantiles."""
    monkeypatch.setattr(module, "REFIT", replace(REFIT, elsewhere=1.0 - 1e-12))
    found = bootstrap(housing, 5)
    assert found.tally[DrawOutcome.ELSEWHERE] == 5
    assert all(spread.deviation > 0.0 for spread in found.spreads)


def test_draws_side_by_side_end_where_each_ends_alone(housing, found, monkeypatch):
    """Truth: each draw refitted as any record is; both stop where the cost falls by less than 1e-3 sigmas squared."""
    monkeypatch.setattr(module, "chord_at", lambda *_: None)
    alone = bootstrap(housing, 6)
    for one, other in zip(found.draws[:6], alone.draws, strict=True):
        assert one.outcome is other.outcome
        assert one.cost == pytest.approx(other.cost, abs=2e-3)
        for spread in found.spreads:
            assert one.values[spread.name] == pytest.approx(other.values[spread.name], abs=0.04 * spread.deviation)


def test_a_draw_that_the_slopes_do_not_bring_home_is_refitted(housing, found, monkeypatch):
    """Truth: the refit of each draw; with no steps the chord method brings none to its optimum."""
    monkeypatch.setattr(chord, "REFIT", replace(REFIT, chord_steps=0))
    again = bootstrap(housing, 2)
    assert again.tally[DrawOutcome.CONVERGED] == 2
