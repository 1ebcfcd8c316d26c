"""Error bars where the model lacks something: against another library's clusters, refits, noise alone, and truths."""

from dataclasses import replace

import numpy as np
import pytest
import statsmodels.api as sm

from mechid.identification.identify import identify
from mechid.identification.output_error.misfit import Misfit
from mechid.identification.output_error.problem import Problem
from mechid.identification.output_error.reduction import WeightedRows
from mechid.identification.output_error.space import SearchSpace
from mechid.identification.output_error.target import target_of
from mechid.identification.result.grade import Consistency, Scatter
from mechid.identification.result.settings import GRADE
from mechid.identification.search.solve import solve
from mechid.identification.uncertainty import model_error
from mechid.identification.uncertainty.covariance import scores
from mechid.identification.uncertainty.model_error import (
    Comparison,
    ModelError,
    clustered_covariance,
    jackknife_covariance,
)
from mechid.identification.uncertainty.parts import Parts, RecordParts
from mechid.identification.uncertainty.settings import ERRORS
from synthetic import COMMANDS, NOISE_NM, campaign, displaced, measured, record, truth

FREE = {"gear.stiffness": 1.002, "gear.damping": 1.02, "stepper.torque_constant": 0.998, "friction.coulomb": 1.0}
SECONDS = 0.4
MADE = ("full_46", "full_23", "micro_46")


def records_of(mechanism, seed, seconds=SECONDS, names=MADE):
    rngs = np.random.default_rng(seed).spawn(len(names))
    return [
        record(n, measured(mechanism, COMMANDS[n], rng, seconds=seconds), COMMANDS[n])
        for n, rng in zip(names, rngs, strict=True)
    ]


def problem_of(mechanism, seed):
    """Return the problem of some records that a mechanism makes, fitted with the four parameters of `FREE` free."""
    targets = tuple(target_of(r) for r in records_of(mechanism, seed))
    problem = Problem(SearchSpace(displaced(truth(), FREE)), targets, substeps=2).with_sigmas(
        dict.fromkeys(MADE, NOISE_NM)
    )
    return problem, solve(problem, problem.start, problem.whole_windows())


@pytest.fixture(scope="module")
def fitted():
    return problem_of(truth(), 31)


def rows_of(problem, q, target):
    """Return what the fit sees of a record, r and J in sigmas, offset and drift projected out, (N, 1 + n)."""
    window = (0, target.samples)
    blocks = [
        rows[:, :n].copy() for _, rows, n in WeightedRows(Misfit(problem.model, target, q, window, jacobian=True))
    ]
    rows = np.concatenate(blocks, axis=1).T
    phi, rest = rows[:, :2], rows[:, 2:] / target.leading.scale
    return rest - phi @ np.linalg.lstsq(phi, rest, rcond=None)[0]


def test_clusters_by_phase_are_those_of_statsmodels(fitted):
    """Truth: statsmodels' cluster-robust covariance of the same rows, its factor G / (G - 1) written out.

    It takes the scores as they are; ours have their mean removed, which is nothing at an optimum.
    """
    problem, solution = fitted
    q = solution.q
    rows = [rows_of(problem, q, t) for t in problem.targets]
    times = np.arange(len(rows[0])) / 1e4
    rates = [float(COMMANDS[t.name].rate.rates[0]) for t in problem.targets]
    groups = [k * ERRORS.phases + np.floor(ERRORS.phases * ((rate * times) % 1.0)) for k, rate in enumerate(rates)]
    rJ = np.concatenate(rows)
    step = np.linalg.lstsq(rJ[:, 1:], rJ[:, 0], rcond=None)[0]
    ols = sm.OLS(rJ[:, 0] - rJ[:, 1:] @ step, rJ[:, 1:])
    found = ols.fit(
        cov_type="cluster", cov_kwds={"groups": np.concatenate(groups).astype(int), "use_correction": False}
    )
    parts = scores(problem, q, problem.whole_windows()).parts
    g = np.concatenate([p.phases.scores - p.phases.information @ step for p in parts])
    ours = clustered_covariance(g, np.linalg.inv(rJ[:, 1:].T @ rJ[:, 1:]))
    theirs = found.cov_params() * len(g) / (len(g) - 1)
    size = np.sqrt(np.outer(np.diag(theirs), np.diag(theirs)))
    np.testing.assert_allclose(ours / size, theirs / size, atol=1e-6)


def test_leaving_out_a_record_is_a_fit_without_it(fitted, monkeypatch):
    """Truth: linear least squares of the other records' rows, from the same point."""
    monkeypatch.setattr(model_error, "ERRORS", replace(ERRORS, jackknife_ridge=1.0))
    problem, solution = fitted
    rows = [rows_of(problem, solution.q, t) for t in problem.targets]
    everything = np.concatenate(rows)
    best = np.linalg.lstsq(everything[:, 1:], everything[:, 0], rcond=None)[0]
    without = []
    for k in range(len(rows)):
        others = np.concatenate(rows[:k] + rows[k + 1 :])
        without.append(np.linalg.lstsq(others[:, 1:], others[:, 0] - others[:, 1:] @ best, rcond=None)[0])
    off = np.array(without) - np.mean(without, axis=0)
    parts = Parts(
        np.array([r[:, 1:].T @ (r[:, 0] - r[:, 1:] @ best) for r in rows]),
        np.array([r[:, 1:].T @ r[:, 1:] for r in rows]),
    )
    expected = (len(rows) - 1) / len(rows) * off.T @ off
    np.testing.assert_allclose(
        jackknife_covariance(parts, everything[:, 1:].T @ everything[:, 1:]), expected, rtol=1e-6, atol=1e-18
    )


def drawn_parts(rng, records, phases, rows, n, common=0.0):
    """Return parts of a linear problem with white noise of 1; `common` is what each phase has in every step."""
    found, information = [], np.zeros((n, n))
    J = [rng.standard_normal((phases, rows, n)) for _ in range(records)]
    r = [rng.standard_normal((phases, rows)) + common * rng.standard_normal((phases, 1)) for _ in range(records)]
    step = np.linalg.lstsq(
        np.concatenate([j.reshape(-1, n) for j in J]), np.concatenate([x.ravel() for x in r]), rcond=None
    )[0]
    for k, (j, x) in enumerate(zip(J, r, strict=True)):
        left = x - j @ step
        parts = Parts(np.einsum("gsi,gs->gi", j, left), np.einsum("gsi,gsj->gij", j, j))
        found.append(RecordParts(str(k), parts, parts, True))
        information += parts.information.sum(axis=0)
    return found, information


@pytest.mark.parametrize(("common", "agrees"), [(0.0, True), (0.3, False)])
def test_parts_of_noise_agree_and_those_of_an_effect_do_not(common, agrees):
    """Truth: what was drawn. J is random, so that an effect common to a phase adds to its score like noise of it."""
    rng = np.random.default_rng(41)
    z = []
    for _ in range(60):
        parts, information = drawn_parts(rng, 4, 32, 40, 6, common)
        if common:  # columns that do not average the effect away
            parts = [replace(p, phases=Parts(p.phases.scores * 3.0, p.phases.information)) for p in parts]
        compared = Comparison(parts, information, np.linalg.inv(information), np.ones(6, dtype=bool))
        assert compared.consistency.agrees is agrees
        z.append(compared.consistency.phase.z)
    assert (max(z) < GRADE.consistency_z_limit) is agrees
    if agrees:  # of chance, mean 0 and deviation 1, each known to its own error over 60 draws
        assert abs(np.mean(z)) < 4.0 / np.sqrt(60)
        assert np.std(z) == pytest.approx(1.0, abs=0.4)


def test_the_matrix_is_never_less_than_noise_and_has_its_metric():
    """Truth: the clip is the same in any coordinates, as the file's are others than the search's."""
    rng = np.random.default_rng(42)
    roots = rng.standard_normal((3, 5, 5))
    noise, excess, turn = (a @ a.T + 0.1 * np.eye(5) for a in roots)
    found = ModelError(noise, (model_error.Excess(excess, 8.0),)).matrix
    assert np.linalg.eigvalsh(found - noise).min() > -1e-9
    turned = ModelError(turn @ noise @ turn.T, (model_error.Excess(turn @ excess @ turn.T, 8.0),)).matrix
    np.testing.assert_allclose(turned, turn @ found @ turn.T, rtol=1e-8)


def test_degrees_of_freedom_are_those_of_the_parts_that_add():
    """Truth: Welch and Satterthwaite by hand: 1 of noise, 3 more by 7 degrees, none of the other kind."""
    error = ModelError(np.eye(1), (model_error.Excess(4.0 * np.eye(1), 7.0), model_error.Excess(0.5 * np.eye(1), 3.0)))
    variance, spread = error.variances(np.eye(1))
    assert variance == pytest.approx([4.0])
    assert variance**2 / spread == pytest.approx([16.0 / (9.0 / 7.0)])


def wrong(mechanism):
    """Return the mechanism with a housing 2 % other than the one that makes the records, and held."""
    return mechanism.with_values({"housing.gain": 4.5})


def test_with_a_complete_model_noise_says_it_all():
    """Truth: the mechanism that made the records; its errors are those of noise, to the bit."""
    start = displaced(truth(), FREE)
    fit = identify(campaign(start, *records_of(truth(), 33)), near={n: start.value(n) for n in FREE}, workers=1)
    assert fit.consistency.agrees
    assert fit.consistency.parameter is None
    for name in FREE:
        p = fit.parameters[name]
        assert (p.std_error, p.dof) == (pytest.approx(p.std_error_noise, rel=1e-12), None)
        assert abs(p.value - truth().value(name)) < 4.0 * p.std_error


@pytest.mark.slow
def test_with_a_wrong_housing_the_errors_reach_the_truth():
    """Truth: the mechanism that made the records. Noise alone would have it many standard errors away."""
    start = wrong(displaced(truth(), FREE))
    fit = identify(campaign(start, *records_of(truth(), 33)), near={n: start.value(n) for n in FREE}, workers=1)
    assert not fit.consistency.agrees
    assert fit.consistency.phase.z > GRADE.consistency_z_limit
    assert fit.consistency.contested_record in MADE
    off = {n: fit.parameters[n].value - truth().value(n) for n in FREE}
    by_noise = [abs(off[n]) / fit.parameters[n].std_error_noise for n in FREE]
    held = [abs(off[n]) / fit.parameters[n].std_error for n in FREE]
    assert max(by_noise) > 5.0
    assert max(held) < 3.0
    assert all(fit.parameters[n].dof < 100.0 for n in FREE)
    widened = {n: fit.parameters[n].std_error / fit.parameters[n].std_error_noise for n in FREE}
    assert fit.consistency.parameter == max(widened, key=widened.get)
    low, high = fit.parameters["gear.stiffness"].ci95
    assert high - low > 2.0 * 1.96 * fit.parameters["gear.stiffness"].std_error


@pytest.mark.parametrize(
    ("phase", "record", "agrees"), [(0.0, 0.0, True), (5.0, 0.0, False), (None, 5.0, False), (None, None, False)]
)
def test_stretches_of_time_decide_where_nothing_else_is_tested(phase, record, agrees):
    """Truth: hum, whose stretches scatter by 20 while phases and records do not, moves no value."""

    def scatter(z):
        return None if z is None else Scatter(ratio=1.0, z=z, clusters=10)

    assert Consistency(phase=scatter(phase), record=scatter(record), time=scatter(20.0)).agrees is agrees
